// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/datasets/yaml_map.h"
#include "core/geometry/calibration.h"

namespace plslam {

/// Adds what a camera's keys leave out of its images (the bonnet of a car, an arm of the robot, a lens hood) to the
/// mask of `camera`, whose size is known; all in pixels of the image as recorded. `mask` is an image of the same
/// size, beside the file or below: 0 (black) is left out, all else in use. `mask_polygons` and `borders_px` [left,
/// top, right, bottom] are left out. Throws DatasetError that names file, line, key, value and bound.
void ReadMask(const YamlMap& yaml, CameraCalibration* camera);

/// Adds what the image at `path` leaves out. Throws DatasetError that names it.
void AddMaskImage(const std::string& path, CameraCalibration* camera);

}  // namespace plslam
