// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/stereo_front_end.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/features/points/fast_score.h"
#include "core/geometry/image_mask.h"
#include "vo_process/stereo/point_stereo.h"
#include "vo_process/stereo/stereo_matcher.h"

namespace plslam::vo {
namespace {

// In pixels of the point's octave: with eight octaves, corners are compared up to 14 pixels apart.
constexpr double kUnknownRowTolerance_px = 4.0;
constexpr double kUnknownRowSigma_px = 2.0;
// Most corners of the right image at half size.
constexpr int kMostRightCorners = 400;

/// Masked regions may have more corners than the rest, so the detector skips them; the few corners along the edge of a
/// warped image are removed afterwards.
std::vector<PointFeature> PointsInside(FeatureExtractor& extractor, const cv::Mat& image, bool leaves_out,
                                       const FeatureMask& mask, std::optional<int> max_points) {
  ImageFeatures features;
  features.points = extractor.ExtractPoints(image, leaves_out ? mask.inside() : cv::Mat(), max_points);
  mask.RemoveOutside(features);
  return std::move(features.points);
}

std::vector<LineFeature> LinesInside(FeatureExtractor& extractor, const cv::Mat& image, const FeatureMask& mask) {
  ImageFeatures features;
  features.lines = extractor.ExtractLines(image);
  mask.RemoveOutside(features);
  return std::move(features.lines);
}

/// Corners of the right image are needed without a search along the rows, and if the row of a match depends on its
/// depth, because that search follows a single row.
bool NeedsRightPoints(const RowField& rows, const StereoOptions& options) {
  return !options.point_direct || !rows.skew().is_zero();
}

/// Removes depths from matches in masked regions of the right image, to which the search along the row may lead.
void ForgetPartnersOutside(const FeatureMask& right_mask, StereoFeatures& features) {
  for (StereoPoint& point : features.points) {
    if (!point.HasDepth()) continue;
    if (right_mask.IsOutside(point.left.px - Eigen::Vector2d(point.disparity_px, 0.0))) ForgetPartner(point);
  }
}

}  // namespace

StereoFrontEnd::StereoFrontEnd(const RigCalibration& rig, const VoOptions& options)
    : rig_(rig),
      options_(options),
      rectifier_(rig),
      left_mask_(rectifier_.left_mask()),
      right_mask_(rectifier_.right_mask()),
      left_extractor_(options.features),
      right_extractor_(options.features) {}

void StereoFrontEnd::SetMask(const FrameMask& mask) {
  const auto drawn = [](CameraCalibration camera, const std::vector<MaskPolygon>& polygons) {
    camera.mask = polygons;
    return DrawMask(camera);
  };
  if (mask.left != mask_.left) left_mask_ = FeatureMask(rectifier_.LeftMask(drawn(rig_.left, mask.left)));
  if (mask.right != mask_.right) right_mask_ = FeatureMask(rectifier_.RightMask(drawn(rig_.right, mask.right)));
  mask_ = mask;
}

void StereoFrontEnd::Take(const StereoImages& images, StageTimer& timer) {
  timer.Time("rectify", [&] {
    const bool rgbd = rig_.kind == RigCalibration::Kind::kRgbd;
    worker_.RunBoth([&] { pair_.left = HalvedImages(rectifier_.RectifyLeft(images.left)); },
                    [&] {
                      if (rgbd) {
                        pair_.depth = rectifier_.RectifyDepth(images.right);
                      } else {
                        pair_.right = HalvedImages(rectifier_.RectifyRight(images.right));
                      }
                    });
  });
}

StereoFeatures StereoFrontEnd::Detect(StageTimer& timer, const RowField& rows, std::optional<int> max_points) {
  StereoFeatures features =
      pair_.HasDepthMap() ? DetectRgbd(timer, max_points) : DetectStereo(timer, rows, max_points);
  if (!pair_.HasDepthMap() && LeavesOutRight()) ForgetPartnersOutside(right_mask_, features);
  return features;
}

StereoFeatures StereoFrontEnd::Follow(StageTimer& timer, const RowField& rows, const SE3& T_odom_previous,
                                      const SE3& T_odom_now, FeatureTracker& tracker) {
  return timer.Time("follow", [&] {
    tracker.Track(pair_, {rows, dirt_, T_odom_previous, T_odom_now, rig_.depth_units_per_m}, OnBothThreads());
    tracker.RemoveIf([&](const StereoPoint& point) { return left_mask_.IsOutside(point.left.px); },
                     [&](const StereoLine& line) { return IsMasked(line); });
    StereoFeatures features = tracker.Features();
    if (!pair_.HasDepthMap() && LeavesOutRight()) ForgetPartnersOutside(right_mask_, features);
    return features;
  });
}

/// Whether a mask hides the line in the left image, or its partner in the right one.
bool StereoFrontEnd::IsMasked(const StereoLine& line) const {
  const Segment2& left = line.left.segment;
  const Eigen::Vector2d p = left.p - Eigen::Vector2d(line.disparity_p_px, 0.0);
  const Eigen::Vector2d q = left.q - Eigen::Vector2d(line.disparity_q_px, 0.0);
  return left_mask_.IsOutside(left) || (!pair_.HasDepthMap() && right_mask_.IsOutside(Segment2{p, q}));
}

StereoFeatures StereoFrontEnd::LookForRows(const PairSkew& skew) {
  if (pair_.HasDepthMap() || options_.features.features == FeatureTypes::kLines) return {};
  StereoOptions options = options_.stereo;
  options.row_sigma_px = std::max(options.row_sigma_px, kUnknownRowSigma_px);
  options.point_row_tolerance_px = std::max(options.point_row_tolerance_px, kUnknownRowTolerance_px);
  const cv::Mat& left = pair_.left.front();
  const cv::Mat& right = pair_.right.front();
  ImageFeatures left_features;
  ImageFeatures right_features;
  worker_.RunBoth(
      [&] { left_features.points = PointsInside(left_extractor_, left, LeavesOutLeft(), left_mask_, std::nullopt); },
      [&] {
        right_features.points = PointsInside(right_extractor_, right, LeavesOutRight(), right_mask_, std::nullopt);
      });
  StereoFeatures features = MatchStereo(std::move(left_features), std::move(right_features), left, right,
                                        RowField().With(skew), options, OnBothThreads());
  if (LeavesOutRight()) ForgetPartnersOutside(right_mask_, features);
  return features;
}

RunBoth StereoFrontEnd::OnBothThreads() {
  return
      [this](const std::function<void()>& here, const std::function<void()>& there) { worker_.RunBoth(here, there); };
}

void StereoFrontEnd::FindRightCorners() {
  right_corners_.clear();
  if (pair_.right.size() < 2 || options_.features.features == FeatureTypes::kLines) return;
  const cv::Mat& half = pair_.right[1];
  const OrbOptions& orb = options_.features.orb;
  const auto corners = right_detector_.Detect(half, orb.fast_threshold, orb.min_fast_threshold, kFastRadius_px);
  for (const Corner& corner : SpreadCorners(corners, kMostRightCorners, half.cols, half.rows)) {
    const Eigen::Vector2d px = 2.0 * right_detector_.SubPixel(corner);
    if (!right_mask_.IsOutside(px)) right_corners_.push_back(px);
  }
}

/// Left points take as long as right lines, so these run in parallel; then the matching of points in parallel with
/// left lines and the matching of lines. The thread that has finished the lines helps with the points. Without points,
/// lines of both images are detected in parallel.
StereoFeatures StereoFrontEnd::DetectStereo(StageTimer& timer, const RowField& rows, std::optional<int> max_points) {
  ImageFeatures left_features;
  ImageFeatures right_features;
  const cv::Mat& left = pair_.left.front();
  const cv::Mat& right = pair_.right.front();
  const bool lines_alone = options_.features.features == FeatureTypes::kLines;
  const auto find_left_lines = [&] { left_features.lines = LinesInside(left_extractor_, left, left_mask_); };
  timer.Time("features", [&] {
    worker_.RunBoth(
        [&] {
          left_features.points = PointsInside(left_extractor_, left, LeavesOutLeft(), left_mask_, max_points);
          if (lines_alone) find_left_lines();
        },
        [&] {
          right_features.lines = LinesInside(right_extractor_, right, right_mask_);
          FindRightCorners();
          if (!NeedsRightPoints(rows, options_.stereo)) return;
          right_features.points = PointsInside(right_extractor_, right, LeavesOutRight(), right_mask_, max_points);
        });
  });
  return timer.Time("stereo", [&] {
    const HalvedPair pair(pair_.left, pair_.right);
    PairMatcher matcher(pair, rows, options_.stereo);
    matcher.SetPoints(std::move(left_features.points), std::move(right_features.points));
    worker_.RunBoth([&] { matcher.MatchPoints(); },
                    [&] {
                      if (!lines_alone) find_left_lines();
                      matcher.MatchLines(std::move(left_features.lines), std::move(right_features.lines), dirt_);
                      matcher.MatchPoints();
                    });
    return matcher.Finish();
  });
}

StereoFeatures StereoFrontEnd::DetectRgbd(StageTimer& timer, std::optional<int> max_points) {
  ImageFeatures features;
  timer.Time("features", [&] {
    const cv::Mat& left = pair_.left.front();
    worker_.RunBoth(
        [&] { features.points = PointsInside(left_extractor_, left, LeavesOutLeft(), left_mask_, max_points); },
        [&] { features.lines = LinesInside(left_extractor_, left, left_mask_); });
  });
  return timer.Time("stereo", [&] {
    return AttachDepth(std::move(features), pair_.depth, rig_.depth_units_per_m, camera(), options_.stereo);
  });
}

}  // namespace plslam::vo
