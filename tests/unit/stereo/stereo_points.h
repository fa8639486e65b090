// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "vo_process/stereo/point_stereo.h"

namespace plslam::test {

/// Calls MatchPointsStereo with all its inputs prepared.
void Match(std::vector<StereoPoint>& points, const std::vector<PointFeature>& right_points, const cv::Mat& left,
           const cv::Mat& right, const StereoOptions& options);

/// Returns the points of the left image, with depth if they match in the right one.
std::vector<StereoPoint> Match(const cv::Mat& left, const cv::Mat& right, const StereoOptions& options = {});

/// Returns the share from 0 to 1; 0 without points.
double ShareWithDepth(const std::vector<StereoPoint>& points);

}  // namespace plslam::test
