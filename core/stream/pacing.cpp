// SPDX-License-Identifier: BSD-3-Clause
#include "core/stream/pacing.h"

#include <fmt/format.h>

#include <charconv>
#include <stdexcept>
#include <string_view>

#include "core/run/process_names.h"

namespace plslam::stream {
namespace {

constexpr std::string_view kRealtime = stream_pace::kRealtime;
constexpr double kMinSpeed = 1e-3;
constexpr double kMaxSpeed = 1e3;

}  // namespace

Pace ParsePace(const std::string& text) {
  if (text == stream_pace::kLockstep) return {true, 1.0};
  if (text == kRealtime) return {false, 1.0};
  if (text.starts_with(kRealtime) && text.size() > kRealtime.size() + 1 && text[kRealtime.size()] == 'x') {
    double speed = 0.0;
    const char* first = text.data() + kRealtime.size() + 1;
    const char* last = text.data() + text.size();
    const auto [end, error] = std::from_chars(first, last, speed);
    if (error == std::errc() && end == last && speed >= kMinSpeed && speed <= kMaxSpeed) return {false, speed};
  }
  throw std::runtime_error(fmt::format("pace '{}' is not one of lockstep, realtime, realtimexN (N from {} to {})",
                                       text, kMinSpeed, kMaxSpeed));
}

ResumePoint ParseResumePoint(const std::string& text) {
  ResumePoint point;
  const char* end = text.data() + text.size();
  const auto [at, id_error] = std::from_chars(text.data(), end, point.frame_id.value);
  if (id_error == std::errc() && at != end && *at == '@' && point.frame_id >= 0) {
    const auto [last, t_error] = std::from_chars(at + 1, end, point.t_ns);
    if (t_error == std::errc() && last == end) return point;
  }
  throw std::runtime_error(fmt::format("'{}' is not ID@T_NS, number and time of a frame", text));
}

std::string ToText(const ResumePoint& point) { return fmt::format("{}@{}", point.frame_id, point.t_ns); }

RealtimeClock::RealtimeClock(double speed, int64_t period_ns)
    : speed_(speed), tolerance_ns_(static_cast<int64_t>(0.5 * static_cast<double>(period_ns) / speed)) {}

int64_t RealtimeClock::Due_ns(int64_t t_ns, int64_t now_ns) {
  if (!first_t_ns_) {
    first_t_ns_ = t_ns;
    first_due_ns_ = now_ns;
  }
  return first_due_ns_ + static_cast<int64_t>(static_cast<double>(t_ns - *first_t_ns_) / speed_);
}

}  // namespace plslam::stream
