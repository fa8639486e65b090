// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace plslam::test {

/// One file of a calibration: its name and its text.
struct ForeignFile {
  std::string name;
  std::string text;
};

/// One rig, written by hand in one format.
struct ForeignRig {
  std::string format;
  std::vector<ForeignFile> files;
  /// Files that those name.
  std::vector<ForeignFile> beside{};
};

/// The same rig in every supported format: 672 x 376 pixels, "radtan" lenses, the right camera at (0.12, 0.035, 0) m in
/// the left one and rotated about y by the quaternion (w 0.99712, y 0.07584), which is a unit quaternion in exactly
/// these digits.
const std::vector<ForeignRig>& ForeignRigs();
/// The settings files of SLAM programs among them.
std::vector<ForeignRig> SlamSettings();

}  // namespace plslam::test
