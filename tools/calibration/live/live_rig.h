// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/geometry/se3.h"
#include "core/io/images/image_file.h"

namespace plslam::calibration {

/// The file in a folder of live pictures that records their source.
inline constexpr const char* kRigOfPictures = "camera.rig.yaml";

/// A rig file whose cameras may have no calibration yet: `source`, and `resolution_px` of `left`.
struct LiveRigFile {
  std::string name = "camera";
  SE3 T_b_left;
  double rate_hz = 0.0;
  ImageSize size;
  /// The map `source` as YAML with absolute names of files, to append to a calibration.
  std::string source;
  /// A rig file for the process `camera`, which sends images as recorded; its lens values are placeholders.
  std::string for_camera;
};

/// Throws DatasetError that names file, line and key, also of keys that a calibration would not take over (masks).
LiveRigFile ReadLiveRigFile(const std::string& path);

}  // namespace plslam::calibration
