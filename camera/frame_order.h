// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

namespace plslam::camera {

/// Decides which frames are new, by their times.
///
/// Files: those after the frame at which the stream resumes. Live frames are new, regardless of the clock of a previous
/// process; only frames after a clock step back of less than a second are skipped, since the stream continues.
class FrameOrder {
 public:
  static constexpr int64_t kClockStep_ns = 1'000'000'000;

  /// `resumes_after_t_ns`: the time of the last frame of a previous process; nullopt: there was none.
  void OnBegin(const std::optional<int64_t>& resumes_after_t_ns) { resumes_after_t_ns_ = resumes_after_t_ns; }
  void OnFrame(int64_t t_ns) { last_t_ns_ = t_ns; }

  bool IsNew(int64_t t_ns, bool is_live) const {
    if (!is_live) return !resumes_after_t_ns_ || t_ns > *resumes_after_t_ns_;
    return !last_t_ns_ || t_ns > *last_t_ns_ || *last_t_ns_ - t_ns >= kClockStep_ns;
  }
  bool has_frames() const { return last_t_ns_.has_value(); }
  bool has_resumed() const { return resumes_after_t_ns_.has_value(); }

 private:
  std::optional<int64_t> resumes_after_t_ns_;
  std::optional<int64_t> last_t_ns_;
};

}  // namespace plslam::camera
