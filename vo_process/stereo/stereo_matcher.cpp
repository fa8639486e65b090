// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/stereo_matcher.h"

#include <utility>

#include "vo_process/stereo/depth_points.h"
#include "vo_process/stereo/line_stereo.h"
#include "vo_process/stereo/point_stereo.h"
#include "vo_process/stereo/row_field.h"

namespace plslam::vo {
namespace {

/// Moves a right feature to its row in the left image.
void ToLeftRow(const RowField& rows, Eigen::Vector2d& px) { px.y() = rows.LeftRow_px(px); }

/// Removes the effect of the residual rotation, known from the rows, from disparities.
void RemoveRotationDisparity(const RowField& rows, StereoFeatures& features) {
  if (rows.is_zero()) return;
  CorrectDisparities(features, [&rows](const Eigen::Vector2d& left_px, double disparity_px) {
    return rows.Disparity_px(left_px - Eigen::Vector2d(disparity_px, 0.0));
  });
}

}  // namespace

PairMatcher::PairMatcher(const HalvedPair& pair, const RowField& rows, const StereoOptions& options)
    : pair_(pair), rows_(rows), options_(options) {}

void PairMatcher::SetPoints(std::vector<PointFeature> left, std::vector<PointFeature> right) {
  right_points_ = std::move(right);
  if (!rows_.is_zero()) {
    for (PointFeature& point : right_points_) ToLeftRow(rows_, point.px);
  }
  features_.points = WithoutDepth(std::move(left), options_);
  candidates_ = FindPointCandidates(features_.points, right_points_, rows_.skew(), options_);
}

void PairMatcher::MatchPoints() {
  MatchPointsStereo(features_.points, right_points_, candidates_, pair_, rows_, options_, begun_points_);
}

void PairMatcher::MatchLines(std::vector<LineFeature> left, std::vector<LineFeature> right, const PairDirt& dirt) {
  if (!rows_.is_zero()) {
    for (LineFeature& line : right) {
      ToLeftRow(rows_, line.segment.p);
      ToLeftRow(rows_, line.segment.q);
    }
  }
  features_.lines = WithoutDepth(std::move(left));
  MatchLinesStereo(features_.lines, right, pair_.full().left, pair_.full().right, rows_, options_, dirt);
}

StereoFeatures PairMatcher::Finish() {
  ToSimultaneous(rows_, features_);
  return std::move(features_);
}

void ToSimultaneous(const RowField& rows, StereoFeatures& features) {
  RemoveRotationDisparity(rows, features);
  RemoveSkew(rows.skew(), features);
}

StereoFeatures MatchStereo(ImageFeatures left, ImageFeatures right, const cv::Mat& left_image,
                           const cv::Mat& right_image, const RowField& rows, const StereoOptions& options,
                           const RunBoth& run_both) {
  const HalvedPair pair(left_image, right_image);
  PairMatcher matcher(pair, rows, options);
  matcher.SetPoints(std::move(left.points), std::move(right.points));
  run_both([&] { matcher.MatchPoints(); },
           [&] {
             matcher.MatchLines(std::move(left.lines), std::move(right.lines));
             matcher.MatchPoints();
           });
  return matcher.Finish();
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

}  // namespace plslam::vo
