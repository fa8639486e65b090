// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace plslam::synthetic {

/// How bodies move; see `Bodies`.
enum class BodyMotion { kLead, kOvertake, kCross, kStop, kCrowd };

/// The options in the text after "synthetic:". Zero means: the world's own default (see the table in the docs).
struct Options {
  std::string world;
  uint64_t seed = 1;
  int frames = 0;
  int loops = 1;
  int changed_after = 0;  ///< laps after which things in a room are replaced or moved; 0: never
  int width_px = 752;
  int height_px = 480;
  double noise = 2.0;     ///< standard deviation, grey levels
  double blur = 0.0;      ///< share of the time between frames that the shutter is open
  double exposure = 1.0;  ///< strength of the slow changes of exposure; 1 means +-20 %
  double baseline_m = 0.0;
  double fov_deg = 0.0;
  double rate_hz = 20.0;
  double speed = 0.0;  ///< metres a second along the path
  bool distorted = false;
  bool standing = false;       ///< the camera keeps its pose of frame 0
  double turning_deg_s = 0.0;  ///< the camera keeps its place, and turns to the left about the vertical
  int bodies = 0;              ///< number of moving boxes
  BodyMotion body = BodyMotion::kLead;
  double share = 0.45;         ///< of the width of the image that a body covers, all together of a crowd
  double static_body = 0.0;    ///< share of the height of the image that a bonnet covers
  double right_late_ms = 0.0;  ///< the right image is taken this much later than the left one
  double readout_ms = 0.0;     ///< the time from the first row of an image to its last
  bool readout_known = false;  ///< the calibration states it
  int streaks = 0;             ///< of snow, in an image
  int dirt = 0;                ///< spots on each lens
  double imu_rate_hz = 0.0;    ///< of an inertial sensor; 0: there is none
  std::string imu_class = "adis16448";
  std::string imu_fault;        ///< name of a fault of that sensor; empty: it is healthy
  double imu_fault_size = 0.0;  ///< the fault's own default if it is not given
  /// Added to all disparities at the centres of the left, middle and right third of the left image.
  std::array<double, 3> disparity_bias_px{};
  std::string trajectory;
};

/// Reads "NAME?option=value&option=value". Throws DatasetError in one sentence that names the nearest known world or
/// option, or the bounds of a value.
Options ParseOptions(const std::string& description);

/// Return the names of the worlds, options and values of `body`, `imu_class` and `imu_fault`, in the order of the documentation.
const std::vector<std::string>& WorldNames();
std::vector<std::string> OptionNames();
const std::vector<std::string>& BodyNames();
std::vector<std::string> ImuClassNames();
std::vector<std::string> ImuFaultNames();

}  // namespace plslam::synthetic
