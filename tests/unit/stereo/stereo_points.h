// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "vo_process/stereo/point_stereo.h"

namespace plslam::test {

/// MatchPointsStereo with all that it wants prepared.
void Match(std::vector<StereoPoint>& points, const std::vector<PointFeature>& right_points, const cv::Mat& left,
           const cv::Mat& right, const StereoOptions& options);

/// The points of the left image, with depth where the right one tells it.
std::vector<StereoPoint> Match(const cv::Mat& left, const cv::Mat& right, const StereoOptions& options = {});

/// From 0 to 1; 0 where there are no points.
double ShareWithDepth(const std::vector<StereoPoint>& points);

}  // namespace plslam::test
