#include "core/features/stereo_matcher.h"

#include <optional>
#include <utility>

#include "core/features/depth_points.h"
#include "core/features/line_stereo.h"
#include "core/features/point_stereo.h"

namespace plslam {

StereoFeatures MatchStereo(ImageFeatures left, const ImageFeatures& right, const cv::Mat& left_image,
                           const cv::Mat& right_image, const StereoCamera& camera, const StereoOptions& options,
                           const RunBoth& run_both) {
  StereoFeatures features;
  features.points = WithoutDepth(std::move(left.points), options);
  features.lines = WithoutDepth(std::move(left.lines));
  std::vector<PointCandidate> candidates;
  std::optional<HalvedPair> pair;
  run_both([&] { candidates = FindPointCandidates(features.points, right.points, options); },
           [&] {
             if (!features.points.empty()) pair.emplace(left_image, right_image);
             MatchLinesStereo(features.lines, right.lines, left_image, right_image, camera, options);
           });
  if (pair) MatchPointsStereo(features.points, right.points, candidates, *pair, options, run_both);
  return features;
}

StereoFeatures AttachDepth(ImageFeatures left, const cv::Mat& depth, double depth_units_per_m,
                           const StereoCamera& camera, const StereoOptions& options) {
  StereoFeatures features;
  features.points = WithoutDepth(std::move(left.points), options);
  features.lines = WithoutDepth(std::move(left.lines));
  AttachDepthToPoints(features.points, depth, depth_units_per_m, camera, options);
  AttachDepthToLines(features.lines, depth, depth_units_per_m, camera, options);
  return features;
}

}  // namespace plslam
