// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam {

/// A plain folder of stereo images: `camera.yaml` or the calibration of another program (docs/datasets.md), two
/// folders of images with one of the names left and right, image_left and image_right, image_0 and image_1, cam0 and
/// cam1, rgb and depth (RGB-D), and optionally `times.txt` (seconds, one for each frame; else the camera file's
/// `rate_hz` counts them), `groundtruth.txt` (TUM format, interpolated) or `poses.txt` (KITTI format, one for each
/// frame).
///
/// Images are paired and ordered by the last number in their name ("left_012.png" and "right_012.png"; by the complete
/// name if it has none). An image without partner counts as an unreadable frame.
std::unique_ptr<Dataset> OpenImagesDataset(const std::string& folder);

/// Returns whether there is a calibration (`CalibrationOf`).
bool LooksLikeImages(const std::string& folder);

}  // namespace plslam
