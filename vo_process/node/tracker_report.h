// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"
#include "core/io/images/image_file.h"
#include "core/process/process.h"
#include "vo_process/stereo/row_field.h"
#include "vo_process/tracking/calibration/self_calibrator.h"
#include "vo_process/tracking/motion/motion_predictor.h"

namespace plslam::vo {

/// Status of a tracker: counters, state, and warnings about images and calibration.
class TrackerReport {
 public:
  explicit TrackerReport(bus::Process& process) : process_(process) {}

  void Count(const std::string& name, double increment);
  /// Counts a frame, which has no known place in the map if `is_unanchored`.
  void CountUnanchored(bool is_unanchored);
  /// Counts a frame whose time stamp is before that of the previous one, and logs the first.
  void CountTooEarly(FrameId frame_id);
  /// Frames counted so far.
  int64_t frames() { return static_cast<int64_t>(counts_["frames"]); }
  /// Publishes the state if it has changed.
  void SetState(const std::string& state);

  /// A new camera: its vertical disparity is reported again.
  void OnCamera() { vertical_disparity_reported_ = false; }
  /// Counts signs of bad images, and of a bad calibration unless the features are `preselected`: those of depth maps,
  /// and those that were followed because they had a depth, do not show how well images match.
  void LookAt(const StereoImages& images, const StereoFeatures& features, bool preselected);
  /// Reports the vertical disparity once for each camera.
  void ReportVerticalDisparity(const RowField& rows, const StereoCamera& camera);
  /// Sets counters of the time offset, the disparity offset and the readout of the cameras, as estimated so far.
  /// Synchronised and well-calibrated cameras have no such counters.
  void ReportCameraErrors(const SelfCalibrator& calibration);
  /// Sets the counters of the inertial sensor, and publishes a warning once if it contradicts the images, and once if
  /// its samples are faulty.
  void ReportImu(const MotionPredictor& motion);
  /// Publishes warnings with the state, every so many frames.
  void ReportWarnings();
  /// Publishes the end of the stream with the warnings about all of it.
  void Finish();
  bool finished() const;

 private:
  void UpdateWarnings();
  void SetImuFigures(const MotionPredictor& motion);

  bus::Process& process_;
  std::map<std::string, double> counts_;
  std::string state_;
  std::string warnings_;  ///< last published with the state
  bool vertical_disparity_reported_ = false;
  bool imu_reported_ = false;
  bool imu_samples_reported_ = false;
  bool too_early_reported_ = false;
};

}  // namespace plslam::vo
