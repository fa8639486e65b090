#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace plslam::synthetic {

/// What the text after "synthetic:" asks for. Zero means: the world's own default (see the table in the docs).
struct Options {
  std::string world;
  uint64_t seed = 1;
  int frames = 0;
  int loops = 1;
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
  /// Added to all disparities at the centres of the left, middle and right third of the left image.
  std::array<double, 3> disparity_bias_px{};
  std::string trajectory;
};

/// Reads "NAME?option=value&option=value". Throws DatasetError in one sentence that names the nearest known world or
/// option, or the bounds of a value.
Options ParseOptions(const std::string& description);

/// Known worlds and options, in the order of the documentation.
const std::vector<std::string>& WorldNames();
std::vector<std::string> OptionNames();

}  // namespace plslam::synthetic
