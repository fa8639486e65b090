// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/calibration.h"

namespace plslam {

/// Returns the mask of a camera as an image: CV_8UC1 of its size, 255 for pixels in use, 0 for masked ones. Empty if
/// all are in use. A pixel that a polygon touches belongs to the polygon. The same on every machine.
cv::Mat DrawMask(const CameraCalibration& camera);

/// Returns the polygons of an image in which 0 is masked and every other value in use, as in OpenCV and COLMAP. Their
/// sides are within half a pixel of the image's contours, so that a smooth contour needs few corners.
std::vector<MaskPolygon> TraceMask(const cv::Mat& image);

/// Returns what is wrong with the mask of a camera (whose size must be known), in one phrase with value and bound;
/// empty if it is valid. Errors: too many corners (`kMaxMaskCorners`), a corner farther than one image size from the
/// image, no pixel in use.
std::string MaskComplaint(const CameraCalibration& camera);

/// Tints the part of a CV_8UC3 picture where `mask`, of its size or empty, is 0.
void ShadeMask(const cv::Mat& mask, cv::Mat& picture);

}  // namespace plslam
