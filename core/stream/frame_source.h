// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"
#include "core/io/images/image_file.h"
#include "core/stream/pacing.h"

namespace plslam::stream {

/// A frame ready to be sent; or why it cannot be.
struct LoadedFrame {
  StereoImages images;
  std::optional<SE3> T_w_l;
  std::string error;
  /// Samples of the inertial sensor from the last one at or before the previous frame, which was at this time, to the
  /// first one at or after this frame; empty if the sensor has no samples of this motion.
  std::vector<ImuSample> imu{};
  int64_t imu_from_ns = 0;
};

/// A source of stereo frames in order: a dataset or cameras. `Begin` and `Next` are called on one thread, `Stop` on
/// any.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual std::string name() const = 0;
  virtual const RigCalibration& rig() const = 0;
  /// Number of frames; -1 if it is not known.
  virtual int64_t size() const = 0;
  /// Mean step between the frames, as far as it is known before the first one.
  virtual int64_t period_ns() const = 0;
  /// Frames arrive at their own time and cannot be delayed.
  virtual bool is_live() const { return false; }
  /// Returns whether there is recorded truth, of whatever frames.
  virtual bool HasRecordedTruth() const { return false; }

  /// Begins from the first frame, or with the first one after a frame that was already sent; called before the first
  /// `Next`, and again whenever older frames are requested again. Returns the number of skipped frames that were never
  /// sent, since they were unreadable.
  virtual int64_t Begin(const std::optional<ResumePoint>& behind) = 0;
  /// Waits for the next frame; nullopt after the last one and after `Stop`. Throws if there will be no further frame.
  virtual std::optional<LoadedFrame> Next() = 0;
  /// Ends `Next` permanently.
  virtual void Stop() = 0;
};

}  // namespace plslam::stream
