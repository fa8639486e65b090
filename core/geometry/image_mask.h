// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/calibration.h"

namespace plslam {

/// The mask of a camera as an image: CV_8UC1 of its size, 255 where pixels are in use, 0 where they are left out.
/// Empty where all are in use. A pixel that a polygon touches belongs to the polygon. The same on every machine.
cv::Mat DrawMask(const CameraCalibration& camera);

/// Polygons of an image in which 0 is left out and every other value in use, as OpenCV and COLMAP have it. Their
/// sides lie within half a pixel of where the image has them, so that a smooth outline takes few corners.
std::vector<MaskPolygon> TraceMask(const cv::Mat& image);

/// What is wrong with the mask of a camera (its size must be known), in one phrase with value and bound; empty where
/// nothing is: too many corners (`kMaxMaskCorners`), a corner farther than one image size from the image, or no pixel
/// in use.
std::string MaskComplaint(const CameraCalibration& camera);

/// Tints the part of a CV_8UC3 picture where `mask`, of its size or empty, is 0.
void ShadeMask(const cv::Mat& mask, cv::Mat& picture);

}  // namespace plslam
