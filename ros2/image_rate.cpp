// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/image_rate.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

namespace plslam::ros2 {
namespace {

constexpr double kWindow_s = 5.0;
constexpr double kGap_s = 2.0;
constexpr size_t kLeast = 10;
/// Long steps in a row that may be those of another rate; fewer are not decided yet, and those of losses differ.
constexpr size_t kLeastOfOneRate = 8;
constexpr size_t kMostNew = 2000;
constexpr double kLeastShare = 0.9;
/// Room for so many frames: earlier ones are handled while the next one arrives.
constexpr int64_t kFrames = 4;

bool AreOfOneRate(std::span<const int64_t> steps_ns) {
  if (steps_ns.size() < kLeastOfOneRate) return false;
  const auto [least, most] = std::ranges::minmax(steps_ns);
  return most <= least + least / 2;
}

}  // namespace

void ImageRate::Add(int64_t t_ns, double now_s) {
  // A camera that was restarted, or a clock that was set: steps across it are of no rate.
  const bool is_apart =
      !arrivals_.empty() && std::abs(1e-9 * static_cast<double>(t_ns - arrivals_.back().first)) > kGap_s;
  if (is_apart) arrivals_.clear();
  if (!arrivals_.empty()) new_steps_.push_back({t_ns, t_ns - arrivals_.back().first});
  // Without a rate they are of no use: fewer than ten images arrived within five seconds.
  if (new_steps_.size() > kMostNew) new_steps_.erase(new_steps_.begin());
  arrivals_.emplace_back(t_ns, now_s);
}

ImageRate::Rates ImageRate::Of(double now_s) {
  while (!arrivals_.empty() && arrivals_.front().second < now_s - kWindow_s) arrivals_.pop_front();
  if (arrivals_.size() < kLeast) return {};
  std::vector<int64_t> steps;
  for (size_t i = 1; i < arrivals_.size(); ++i) steps.push_back(arrivals_[i].first - arrivals_[i - 1].first);
  std::vector<int64_t> sorted = steps;
  const auto tenth = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 10);
  std::nth_element(sorted.begin(), tenth, sorted.end());
  if (*tenth <= 0) return {};
  // Steps without a gap: those that are not much longer than the shortest ones.
  const auto is_whole = [limit_ns = *tenth + *tenth / 2](int64_t step_ns) { return step_ns <= limit_ns; };
  const auto n_before = static_cast<size_t>(std::ranges::find_if(steps, is_whole) - steps.begin());
  const auto n_until =
      static_cast<size_t>(std::find_if(steps.rbegin(), steps.rend(), is_whole).base() - steps.begin());
  const std::span<const int64_t> all(steps), before = all.first(n_before), after = all.subspan(n_until);
  if (AreOfOneRate(after)) {
    arrivals_.erase(arrivals_.begin(), arrivals_.begin() + static_cast<std::ptrdiff_t>(n_until));
    return Of(now_s);
  }
  const size_t begin = AreOfOneRate(before) ? n_before : 0;
  const size_t end = after.size() < kLeastOfOneRate ? n_until : steps.size();
  const int64_t begin_ns = arrivals_[begin].first, end_ns = arrivals_[end].first;
  if (end_ns <= begin_ns) return {};
  double sum_ns = 0.0;
  int n_whole = 0;
  for (const int64_t step_ns : all.subspan(begin, end - begin)) {
    if (!is_whole(step_ns)) continue;
    sum_ns += static_cast<double>(step_ns);
    ++n_whole;
  }
  return {.sent_hz = 1e9 * n_whole / sum_ns,
          .arrived_hz = 1e9 * static_cast<double>(end - begin) / static_cast<double>(end_ns - begin_ns),
          .from_ns = begin > 0 ? begin_ns : INT64_MIN,
          .to_ns = end_ns};
}

void ImageRate::CountMissing(const Rates& rates) {
  std::erase_if(new_steps_, [&](const Step& step) {
    if (step.end_ns > rates.to_ns) return false;
    const double n_steps = 1e-9 * static_cast<double>(step.step_ns) * rates.sent_hz;
    if (step.end_ns > rates.from_ns) n_missing_ += std::max(std::llround(n_steps) - 1, 0LL);
    return true;
  });
}

std::string LossSentence(const ImageRate::Rates& rates, int64_t pair_bytes, int64_t buffer_bytes) {
  if (rates.arrived_hz >= kLeastShare * rates.sent_hz) return "";
  const std::string text = fmt::format("{:.0f} of {:.0f} Hz arrive", rates.arrived_hz, rates.sent_hz);
  const int64_t needed = kFrames * pair_bytes;
  if (buffer_bytes >= needed) return text + ": images are lost between their driver and here";
  return fmt::format("{}: receive buffer {} kB, {} kB needed (sudo sysctl -w net.core.rmem_max={})", text,
                     buffer_bytes / 1000, needed / 1000, needed);
}

std::string SmallBufferSentence(int64_t buffer_bytes) {
  constexpr int64_t kNeeded = kFrames * 2 * 640 * 480;
  if (buffer_bytes >= kNeeded) return "";
  return fmt::format(
      "receive buffer {} kB: a pair of 640 x 480 needs {} kB, and large images are lost with less (sudo sysctl -w "
      "net.core.rmem_max=16777216)",
      buffer_bytes / 1000, kNeeded / 1000);
}

}  // namespace plslam::ros2
