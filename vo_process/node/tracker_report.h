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
#include "vo_process/tracking/disparity_calibration.h"
#include "vo_process/tracking/sync_check.h"

namespace plslam::vo {

/// What a tracker tells of itself in its status: counts, the state, and warnings about images and calibration.
class TrackerReport {
 public:
  explicit TrackerReport(bus::Process& process) : process_(process) {}

  void Count(const std::string& name, double increment);
  /// Frames counted so far.
  int64_t frames() { return static_cast<int64_t>(counts_["frames"]); }
  /// Where it is news.
  void SetState(const std::string& state);

  /// Another one: what was told of its rows is told again.
  void OnCamera() { told_of_rows_ = false; }
  /// Counts what tells of bad images and of a bad calibration.
  void LookAt(const StereoImages& images, const StereoFeatures& features, bool is_rgbd);
  /// Once for each camera.
  void TellOfRows(const RowField& rows, const StereoCamera& camera);
  /// As these are known now, which grows better with time. Of cameras that are in step and well calibrated there are
  /// no such counters.
  void TellOfCameras(const SyncCheck& sync, const DisparityCalibration& calibration);
  /// With the state, for who looks at the run while it goes on; every so many frames.
  void TellOfWarnings();

 private:
  bus::Process& process_;
  std::map<std::string, double> counts_;
  std::string state_;
  std::string warnings_;  ///< what the state is told with
  bool told_of_rows_ = false;
};

}  // namespace plslam::vo
