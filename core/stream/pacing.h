// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/ids/ids.h"

namespace plslam::stream {

/// When frames are sent.
struct Pace {
  bool lockstep = true;
  double speed = 1.0;  ///< real time only: 2 is twice as fast
};

/// From "lockstep", "realtime", "realtimex2", "realtimex0.5" (0.001 to 1000). Throws std::runtime_error.
Pace ParsePace(const std::string& text);

/// The newest answered frame, after which a restarted player resumes.
struct ResumePoint {
  FrameId frame_id = -1;
  int64_t t_ns = 0;

  bool operator==(const ResumePoint&) const = default;
};

/// Parses "ID@T_NS", the format of `player.resume_after`. Throws std::runtime_error.
ResumePoint ParseResumePoint(const std::string& text);
std::string ToText(const ResumePoint& point);

/// Instead of a resume point: after the newest frame that has a pose on the bus.
inline constexpr const char* kResumeFromBus = "bus";

/// Maps the time of frames to that of a steady clock (both in nanoseconds): the first frame is due at once.
class RealtimeClock {
 public:
  /// Frames sent more than half a period after they were due are late.
  RealtimeClock(double speed, int64_t period_ns);

  int64_t Due_ns(int64_t t_ns, int64_t now_ns);
  /// Everything is due so much later from now on.
  void Delay(int64_t by_ns) { first_due_ns_ += by_ns; }
  bool IsLate(int64_t due_ns, int64_t now_ns) const { return now_ns - due_ns > tolerance_ns_; }

 private:
  double speed_;
  int64_t tolerance_ns_;
  std::optional<int64_t> first_t_ns_;
  int64_t first_due_ns_ = 0;
};

}  // namespace plslam::stream
