// SPDX-License-Identifier: BSD-3-Clause
#include "player/pacing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace plslam::player {
namespace {

constexpr double kNsPerS = 1e9;
constexpr double kDefaultRate_hz = 10.0;

std::vector<int> Select(int64_t n, const PlayerOptions& options) {
  const int64_t stop = options.stop < 0 ? n : std::min(options.stop, n);
  if (options.stride < 1 || options.start < 0 || options.start >= stop) {
    throw std::runtime_error(fmt::format("start {}, stop {} and stride {} leave none of the {} frames", options.start,
                                         options.stop, options.stride, n));
  }
  std::vector<int> frames;
  for (int64_t i = options.start; i < stop; i += options.stride) frames.push_back(static_cast<int>(i));
  return frames;
}

int64_t Count(int64_t n, const PlayerOptions& options) {
  const bool turns = options.bounce && n > 1;
  return turns ? 1 + 2 * (n - 1) * options.loop : n * options.loop;
}

}  // namespace

PlayOrder::PlayOrder(int64_t n_frames, TimeOf time_of, const PlayerOptions& options, double rate_hz)
    : time_of_(std::move(time_of)),
      pass_(Select(n_frames, options)),
      bounce_(options.bounce && pass_.size() > 1),
      size_(Count(static_cast<int64_t>(pass_.size()), options)),
      period_ns_(std::max<int64_t>(1, MeanPeriod(rate_hz))),
      t_ns_(time_of_(pass_.front())) {}

int64_t PlayOrder::MeanPeriod(double rate_hz) const {
  if (pass_.size() > 1) {
    return (time_of_(pass_.back()) - time_of_(pass_.front())) / static_cast<int64_t>(pass_.size() - 1);
  }
  const double rate = rate_hz > 0.0 && std::isfinite(rate_hz) ? rate_hz : kDefaultRate_hz;
  return std::llround(kNsPerS / rate);
}

size_t PlayOrder::Position(int64_t step) const {
  const auto n = static_cast<int64_t>(pass_.size());
  if (!bounce_) return static_cast<size_t>(step % n);
  const int64_t turn = step % (2 * (n - 1));
  return static_cast<size_t>(turn < n ? turn : 2 * (n - 1) - turn);
}

std::optional<PlayOrder::Item> PlayOrder::Next() {
  if (step_ == size_) return std::nullopt;
  const size_t now = Position(step_);
  if (step_ > 0) {
    const size_t before = Position(step_ - 1);
    const bool neighbours = now == before + 1 || before == now + 1;
    // A single frame, and the jump back to the first one, have no time step of their own.
    const bool in_pass = neighbours && (bounce_ || now > before);
    t_ns_ += in_pass ? std::abs(time_of_(pass_[now]) - time_of_(pass_[before])) : period_ns_;
  }
  ++step_;
  return Item{pass_[now], t_ns_};
}

int64_t PlayOrder::SkipTo(int64_t t_ns) {
  int64_t skipped = 0;
  for (;; ++skipped) {
    const auto before = std::pair(step_, t_ns_);
    const auto item = Next();
    if (item && item->t_ns <= t_ns) continue;
    std::tie(step_, t_ns_) = before;
    return skipped;
  }
}

}  // namespace plslam::player
