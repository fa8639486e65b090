// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/feature_tracker.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/features/lines/line_sigma.h"
#include "core/motion/motion_estimator.h"
#include "vo_process/stereo/depth_points.h"
#include "vo_process/stereo/halved_pair.h"
#include "vo_process/stereo/line_stereo.h"
#include "vo_process/stereo/patch_aligner.h"
#include "vo_process/stereo/point_stereo.h"
#include "vo_process/stereo/stereo_matcher.h"

namespace plslam::vo {
namespace {

constexpr double kMinCorrelation = 0.8;
constexpr double kMinGain = 0.25;
constexpr double kMaxGain = 4.0;
// Factor of the sigma of disparities, whose errors are for the most part those of the first frame.
constexpr double kRepeatedDisparity = 2.0;
// Points by which the expected motion is improved.
constexpr size_t kSeeds = 80;
constexpr size_t kShiftSeeds = 40;
// Features that a thread takes at once: some microseconds each.
constexpr size_t kFeaturesAtATime = 8;

Eigen::Vector3d Measurement(const Eigen::Vector2d& px, double disparity_px) { return {px.x(), px.y(), disparity_px}; }

bool IsGood(const std::optional<TrackedPatch>& found) {
  return found && found->correlation >= kMinCorrelation && found->gain >= kMinGain && found->gain <= kMaxGain;
}

}  // namespace

/// Position, disparity, and derivative for the surface as the first pair showed it.
std::optional<FeatureTracker::ExpectedPoint> FeatureTracker::Expect(const Expected& motion,
                                                                    const FollowedPoint& point) const {
  const Eigen::Vector3d p_now =
      motion.T_now_previous * camera_.Backproject(Measurement(point.seen.left.px, point.disparity_px));
  if (p_now.z() < camera_.MinDepth()) return std::nullopt;
  ExpectedPoint expected;
  expected.patch.px = camera_.Project(p_now);
  expected.disparity_px = camera_.FocalBaseline() / p_now.z();
  if (!camera_.InImage(expected.patch.px, 0.0)) return std::nullopt;
  const SE3 T_now_first = motion.T_now_odom * T_odom_first_;
  const Eigen::Vector3d first = Measurement(point.patch.px, point.first_disparity_px);
  const auto in_now = [&](const Eigen::Vector3d& seen) {
    return camera_.Project(T_now_first * camera_.Backproject(seen));
  };
  const Eigen::Vector2d there = in_now(first);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = Eigen::Vector2d::Unit(axis);
    expected.patch.now_from_then.col(axis) = in_now(first + Measurement(step, point.first_slope(axis))) - there;
  }
  return expected;
}

/// The motion as some of the points show it. If these are not near their expected places, the camera turns in another
/// way: then the shift of the image is searched first.
FeatureTracker::Expected FeatureTracker::Improved(const Expected& motion, const std::vector<cv::Mat>& left) const {
  if (const auto improved = ImprovedFrom(motion, left)) return *improved;
  const auto turned = Turned(motion, left);
  return turned ? ImprovedFrom(*turned, left).value_or(motion) : motion;
}

/// Returns nullopt if most of the points are not found, or do not agree.
std::optional<FeatureTracker::Expected> FeatureTracker::ImprovedFrom(const Expected& motion,
                                                                     const std::vector<cv::Mat>& left) const {
  std::vector<PointCorrespondence> seen;
  size_t n_expected = 0;
  const size_t step = std::max<size_t>(points_.size() / kSeeds, 1);
  for (size_t i = 0; i < points_.size(); i += step) {
    const FollowedPoint& point = points_[i];
    const auto expected = Expect(motion, point);
    if (!expected) continue;
    ++n_expected;
    const auto found = TrackPatch(point.patch, left, expected->patch, SearchRange::kWide);
    if (!IsGood(found)) continue;
    const Eigen::Vector3d before = Measurement(point.seen.left.px, point.disparity_px);
    const double sigma_px = point.seen.sigma_px;
    seen.push_back({camera_.Backproject(before),
                    camera_.BackprojectCovariance(before, sigma_px, point.seen.sigma_disparity_px),
                    Measurement(found->px, -1.0), sigma_px});
  }
  if (2 * seen.size() < n_expected) return std::nullopt;
  MotionOptions options;
  options.max_refinements = 1;
  const auto estimate = EstimateMotion(seen, {}, camera_, motion.T_now_previous, std::nullopt, options);
  if (!estimate || 2 * estimate->n_point_inliers < static_cast<int>(seen.size())) return std::nullopt;
  return Expected{estimate->T_cur_ref, estimate->T_cur_ref * motion.T_now_previous.Inverse() * motion.T_now_odom};
}

/// The motion with the rotation that moves the image as its points show; nullopt if they show none.
std::optional<FeatureTracker::Expected> FeatureTracker::Turned(const Expected& motion,
                                                               const std::vector<cv::Mat>& left) const {
  std::vector<ExpectedPatch> patches;
  const size_t step = std::max<size_t>(points_.size() / kShiftSeeds, 1);
  for (size_t i = 0; i < points_.size(); i += step) {
    if (const auto expected = Expect(motion, points_[i])) patches.push_back({&points_[i].patch, expected->patch.px});
  }
  const auto shift_px = CommonShift(patches, left);
  if (!shift_px) return std::nullopt;
  Vector6d turn = Vector6d::Zero();
  turn.tail<3>() << -shift_px->y() / camera_.f_px, shift_px->x() / camera_.f_px, 0.0;
  const SE3 T_turned_now = SE3::Exp(turn);
  return Expected{T_turned_now * motion.T_now_previous, T_turned_now * motion.T_now_odom};
}

/// Returns whether the point is found in the left image; without depth, until it is measured.
bool FeatureTracker::TrackPoint(const std::vector<cv::Mat>& left, const Expected& motion,
                                FollowedPoint& point) const {
  const auto expected = Expect(motion, point);
  if (!expected) return false;
  const auto found = TrackPatch(point.patch, left, expected->patch, SearchRange::kNear);
  if (!IsGood(found)) return false;
  ForgetPartner(point.seen);
  point.seen.left.px = found->px;
  point.disparity_px = expected->disparity_px;
  return true;
}

/// The same for a line.
bool FeatureTracker::TrackLine(const RectifiedPair& pair, const Known& known, const Expected& motion,
                               StereoLine& line) const {
  const Segment2& before = line.left.segment;
  const Eigen::Vector3d p = motion.T_now_previous * camera_.Backproject(Measurement(before.p, line.disparity_p_px));
  const Eigen::Vector3d q = motion.T_now_previous * camera_.Backproject(Measurement(before.q, line.disparity_q_px));
  line.disparity_p_px = line.disparity_q_px = -1.0;
  if (std::min(p.z(), q.z()) < camera_.MinDepth()) return false;
  const auto level = static_cast<size_t>(line.left.octave);
  if (level >= pair.left.size()) return false;
  const Segment2 expected{camera_.Project(p), camera_.Project(q)};
  const auto left = LocateSegment(pair.left[level], line.left, expected);
  if (!left) return false;
  line.left = *left;
  line.sigma_px = EndSigma_px(line.left);
  if (pair.HasDepthMap()) return true;
  // Ends of what is seen may be elsewhere than expected: depths along the segment are linear in the image as inverses.
  const auto in_right = [&](const Eigen::Vector2d& px) {
    const Eigen::Vector2d along = expected.q - expected.p;
    const double at = (px - expected.p).dot(along) / along.squaredNorm();
    const double disparity_px = camera_.FocalBaseline() * ((1.0 - at) / p.z() + at / q.z());
    const double measured_px = known.rows.Measured_px(px, disparity_px);
    return Eigen::Vector2d(px.x() - measured_px, px.y() + known.rows.MatchOffset_px(px, measured_px));
  };
  const Segment2& now = line.left.segment;
  const auto right = LocateSegment(pair.right[level], line.left, {in_right(now.p), in_right(now.q)});
  if (right) {
    SetDepthFromRight(*right, pair.left.front(), pair.right.front(), known.rows, options_, known.dirt, line);
  }
  return true;
}

void FeatureTracker::Track(const RectifiedPair& pair, const Known& known, const RunBoth& run_both) {
  const SE3 T_now_odom = known.T_odom_now.Inverse();
  const Expected motion = Improved({T_now_odom * known.T_odom_previous, T_now_odom}, pair.left);
  const bool has_depth_map = pair.HasDepthMap();
  std::optional<HalvedPair> both;
  if (!has_depth_map) both.emplace(pair.left, pair.right);
  std::optional<PatchAligner> aligner;
  if (both) aligner.emplace(*both, options_.row_sigma_px, known.rows);
  std::atomic<size_t> begun = 0;
  const size_t n = lines_.size() + points_.size();
  const auto track = [&](size_t i) {
    if (i < lines_.size()) {
      lines_[i].is_found = TrackLine(pair, known, motion, lines_[i].seen);
      return;
    }
    FollowedPoint& point = points_[i - lines_.size()];
    point.is_found = TrackPoint(pair.left, motion, point);
    if (!point.is_found || has_depth_map) return;
    const double expected_px = known.rows.Measured_px(point.seen.left.px, point.disparity_px);
    AlignWithRight(*aligner, expected_px, options_, point.seen);
    if (point.seen.HasDepth()) point.seen.sigma_disparity_px *= kRepeatedDisparity;
  };
  const auto work = [&] {
    for (size_t first = begun.fetch_add(kFeaturesAtATime); first < n; first = begun.fetch_add(kFeaturesAtATime)) {
      for (size_t i = first; i < std::min(first + kFeaturesAtATime, n); ++i) track(i);
    }
  };
  run_both(work, work);
  std::erase_if(points_, [](const FollowedPoint& point) { return !point.is_found; });
  std::erase_if(lines_, [](const FollowedLine& line) { return !line.is_found; });
  StereoFeatures features = Features();
  if (has_depth_map) {
    AttachDepthToPoints(features.points, pair.depth, known.depth_units_per_m, camera_, options_);
    AttachDepthToLines(features.lines, pair.depth, known.depth_units_per_m, camera_, options_);
  } else {
    ToSimultaneous(known.rows, features);
  }
  for (size_t i = 0; i < points_.size(); ++i) {
    points_[i].seen = features.points[i];
    if (features.points[i].HasDepth()) points_[i].disparity_px = features.points[i].disparity_px;
  }
  for (size_t i = 0; i < lines_.size(); ++i) lines_[i].seen = features.lines[i];
  std::erase_if(lines_, [](const FollowedLine& line) { return !line.seen.HasDepth(); });
}

StereoFeatures FeatureTracker::Features() const {
  StereoFeatures features;
  features.points.reserve(points_.size());
  for (const FollowedPoint& point : points_) features.points.push_back(point.seen);
  features.lines.reserve(lines_.size());
  for (const FollowedLine& line : lines_) features.lines.push_back(line.seen);
  return features;
}

void FeatureTracker::Begin(const std::vector<cv::Mat>& left, const StereoFeatures& features) {
  points_.clear();
  lines_.clear();
  for (const StereoPoint& point : features.points) {
    if (!point.HasDepth()) continue;
    const auto patch = StorePatch(left, point.left.px, point.left.scale);
    if (patch) points_.push_back({point, point.disparity_px, *patch, point.disparity_px, point.disparity_slope});
  }
  for (const StereoLine& line : features.lines) {
    if (line.HasDepth()) lines_.push_back({line});
  }
  n_begun_ = Weight();
}

}  // namespace plslam::vo
