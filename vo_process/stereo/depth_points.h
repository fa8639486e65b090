// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/features/options.h"
#include "core/geometry/stereo_camera.h"

namespace plslam::vo {

/// Sets virtual disparities d = b f / Z from a depth map aligned with the left image (16 bits, 0 = unknown).
///
/// Z is the median of the known depths in a 3x3 window; windows with fewer than 5 of them, or with a spread that only
/// a border between surfaces explains, give no depth. The standard deviation is that of a structured-light camera,
/// constant in disparity (sigma_Z = depth_noise_per_m * Z^2, Khoshelham 2012), with the rounding of the depth unit
/// added. An empty map gives no depths. Throws std::invalid_argument for another type than CV_16UC1, or a unit of 0.
void AttachDepthToPoints(std::vector<StereoPoint>& points, const cv::Mat& depth16, double depth_units_per_m,
                         const StereoCamera& camera, const StereoOptions& options);

}  // namespace plslam::vo
