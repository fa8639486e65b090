// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/io/images/image_file.h"

namespace plslam {

/// The calibration of a stereo rig as another program wrote it.
struct ForeignCalibration {
  RigCalibration rig;
  /// "Kalibr camchain", say.
  std::string format;
  /// What was made of its transforms, in one sentence: which direction they have in the file.
  std::string direction;
};

/// The format of a file, found by looking at it; empty where it is none of those that can be read: Kalibr camchain,
/// OpenCV (M1 D1 M2 D2 R T in one file or two), ROS camera_info (two files), ORB-SLAM2 and 3, stella_vslam, Basalt
/// and ZED. Throws nothing.
std::string ForeignFormat(const std::string& path);

/// Reads the one or two files of a rig. `image_size` chooses among the resolutions of ZED files, and fills in where a
/// file does not tell the size (0 x 0: not known). The left camera is the body unless the file knows an IMU. Throws
/// DatasetError that names file, line, key, value and what to do.
ForeignCalibration ReadForeignCalibration(const std::vector<std::string>& paths, const ImageSize& image_size);

/// The files right in `folder` that have a foreign format, in the order of their names. Throws DatasetError where
/// they are of several formats, so that none can be chosen.
std::vector<std::string> FindForeignCalibration(const std::string& folder);

}  // namespace plslam
