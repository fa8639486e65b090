// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/image_rate.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace plslam::ros2 {
namespace {

constexpr double kWindow_s = 5.0;
constexpr double kGap_s = 2.0;
constexpr size_t kLeast = 10;
constexpr double kLeastShare = 0.9;
/// Room for so many frames: earlier ones are handled while the next one arrives.
constexpr int64_t kFrames = 4;

}  // namespace

void ImageRate::Add(int64_t t_ns, double now_s) {
  // A camera that was restarted, or a clock that was set: steps across it are of no rate.
  const bool is_apart =
      !arrivals_.empty() && std::abs(1e-9 * static_cast<double>(t_ns - arrivals_.back().first)) > kGap_s;
  if (is_apart) arrivals_.clear();
  if (!arrivals_.empty()) new_steps_ns_.push_back(t_ns - arrivals_.back().first);
  arrivals_.emplace_back(t_ns, now_s);
}

ImageRate::Rates ImageRate::Of(double now_s) {
  while (!arrivals_.empty() && arrivals_.front().second < now_s - kWindow_s) arrivals_.pop_front();
  if (arrivals_.size() < kLeast) return {};
  std::vector<int64_t> steps;
  for (size_t i = 1; i < arrivals_.size(); ++i) steps.push_back(arrivals_[i].first - arrivals_[i - 1].first);
  const auto tenth = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 10);
  std::nth_element(steps.begin(), tenth, steps.end());
  const int64_t span_ns = arrivals_.back().first - arrivals_.front().first;
  if (*tenth <= 0 || span_ns <= 0) return {};
  // Steps without a gap: those that are not much longer than the shortest ones.
  double sum_ns = 0.0;
  int n_whole = 0;
  for (const int64_t step_ns : steps) {
    if (step_ns > *tenth + *tenth / 2) continue;
    sum_ns += static_cast<double>(step_ns);
    ++n_whole;
  }
  return {.sent_hz = 1e9 * n_whole / sum_ns,
          .arrived_hz = 1e9 * static_cast<double>(steps.size()) / static_cast<double>(span_ns)};
}

void ImageRate::CountMissing(double sent_hz) {
  for (const int64_t step_ns : std::exchange(new_steps_ns_, {})) {
    n_missing_ += std::max(std::llround(1e-9 * static_cast<double>(step_ns) * sent_hz) - 1, 0LL);
  }
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
