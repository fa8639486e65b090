// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/stereo/stereo_points.h"

#include <algorithm>
#include <atomic>

#include "core/features/points/orb_extractor.h"

namespace plslam::test {

void Match(std::vector<StereoPoint>& points, const std::vector<PointFeature>& right_points, const cv::Mat& left,
           const cv::Mat& right, const StereoOptions& options) {
  std::atomic<size_t> begun = 0;
  vo::MatchPointsStereo(points, right_points, vo::FindPointCandidates(points, right_points, vo::PairSkew(), options),
                        vo::HalvedPair(left, right), vo::RowField(), options, begun);
}

std::vector<StereoPoint> Match(const cv::Mat& left, const cv::Mat& right, const StereoOptions& options) {
  OrbExtractor extractor{OrbOptions{}};
  std::vector<StereoPoint> points = vo::WithoutDepth(extractor.Extract(left), options);
  Match(points, extractor.Extract(right), left, right, options);
  return points;
}

double ShareWithDepth(const std::vector<StereoPoint>& points) {
  const auto n = std::count_if(points.begin(), points.end(), [](const StereoPoint& p) { return p.HasDepth(); });
  return static_cast<double>(n) / std::max<double>(1.0, static_cast<double>(points.size()));
}

}  // namespace plslam::test
