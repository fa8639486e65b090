#include "vo_process/stereo/stereo_matcher.h"

#include <optional>
#include <utility>

#include "vo_process/stereo/correct_disparities.h"
#include "vo_process/stereo/depth_points.h"
#include "vo_process/stereo/line_stereo.h"
#include "vo_process/stereo/point_stereo.h"

namespace plslam {
namespace {

/// Brings right features to the rows that they have in the left image.
void ToLeftRows(const RowField& rows, ImageFeatures& right) {
  if (rows.is_zero()) return;
  const auto bring = [&rows](Eigen::Vector2d& px) { px.y() = rows.LeftRow_px(px); };
  for (PointFeature& point : right.points) bring(point.px);
  for (LineFeature& line : right.lines) {
    bring(line.segment.p);
    bring(line.segment.q);
  }
}

/// From disparities, what the rotation that shows in the rows has added to them.
void TakeRotationAway(const RowField& rows, StereoFeatures& features) {
  if (rows.is_zero()) return;
  CorrectDisparities(features, [&rows](const Eigen::Vector2d& left_px, double disparity_px) {
    return rows.Disparity_px(left_px - Eigen::Vector2d(disparity_px, 0.0));
  });
}

}  // namespace

StereoFeatures MatchStereo(ImageFeatures left, ImageFeatures right, const cv::Mat& left_image,
                           const cv::Mat& right_image, const RowField& rows, const StereoOptions& options,
                           const RunBoth& run_both) {
  ToLeftRows(rows, right);
  StereoFeatures features;
  features.points = WithoutDepth(std::move(left.points), options);
  features.lines = WithoutDepth(std::move(left.lines));
  std::vector<PointCandidate> candidates;
  std::optional<HalvedPair> pair;
  run_both([&] { candidates = FindPointCandidates(features.points, right.points, rows.skew(), options); },
           [&] {
             if (!features.points.empty()) pair.emplace(left_image, right_image);
             MatchLinesStereo(features.lines, right.lines, left_image, right_image, rows, options);
           });
  if (pair) MatchPointsStereo(features.points, right.points, candidates, *pair, rows, options, run_both);
  TakeRotationAway(rows, features);
  TakeSkewAway(rows.skew(), features);
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
