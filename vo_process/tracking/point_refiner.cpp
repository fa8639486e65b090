#include "vo_process/tracking/point_refiner.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace plslam {
namespace {

/// What refinement of slanted disparities expects of a slope before it looks (slant_refiner.cpp), and what is
/// expected here.
constexpr double kStereoSlopeInformation = 1.0 / (0.2 * 0.2);
constexpr double kSlopeInformation = 1.0 / (0.1 * 0.1);
constexpr double kMaxSlope = 2.0;
/// Distance of the camera from the plane of the surface; nearer, the plane is seen from the side.
constexpr double kMinPlaneDistance_m = 0.1;
/// Ends of the arms that the shape is measured with, in pixels of the patch.
constexpr double kArm = 4.0;
/// The unknown part of the shape: some of what is known of it, and a little always.
constexpr double kShapeSigma = 0.01;
constexpr double kShapeShare = 0.15;
/// Further from the corner than this many of its deviations, one of the two is wrong.
constexpr double kMaxDisagreement = 4.0;

}  // namespace

void PointRefiner::Slope::Add(const Slope& other) {
  const Eigen::Vector2d sum = information + other.information;
  value += other.information.cwiseQuotient(sum).cwiseProduct(other.value - value);
  information = sum;
}

void PointRefiner::Reference::MakePatch() {
  if (const auto made = MakeReferencePatch(pixels)) patch = std::make_shared<const ReferencePatch>(*made);
}

PointRefiner::Reference* PointRefiner::Find(int64_t landmark_id) {
  return const_cast<Reference*>(std::as_const(*this).Find(landmark_id));
}

const PointRefiner::Reference* PointRefiner::Find(int64_t landmark_id) const {
  const auto found =
      std::lower_bound(references_.begin(), references_.end(), landmark_id,
                       [](const Reference& reference, int64_t id) { return reference.landmark_id < id; });
  return found != references_.end() && found->landmark_id == landmark_id ? &*found : nullptr;
}

std::vector<RefinedPoint> PointRefiner::Refine(const PointLandmarks& landmarks,
                                               const std::vector<LandmarkMatch>& matches, const TrackedFrame& frame,
                                               const SE3& T_odom_c) const {
  std::vector<RefinedPoint> refined;
  if (!options_.enabled || frame.image.empty()) return refined;
  const SE3 T_c_odom = T_odom_c.Inverse();
  for (const LandmarkMatch& match : matches) {
    const PointLandmark& landmark = landmarks.landmarks()[match.landmark];
    const Reference* reference = Find(landmark.id);
    if (reference == nullptr) continue;
    const auto point = RefineOne(*reference, landmark, frame, frame.features.points[match.feature], T_c_odom);
    if (point) refined.push_back({match.feature, *point});
  }
  return refined;
}

std::optional<StereoPoint> PointRefiner::RefineOne(const Reference& reference, const PointLandmark& landmark,
                                                   const TrackedFrame& frame, const StereoPoint& seen,
                                                   const SE3& T_c_odom) const {
  const auto shape = Shape(reference, landmark.p_odom, T_c_odom);
  if (!shape) return std::nullopt;
  const Eigen::Vector2d start_px = camera_.Project(T_c_odom * landmark.p_odom);
  const double shape_sigma = kShapeSigma + kShapeShare * (*shape - Eigen::Matrix2d::Identity()).norm();
  std::optional<ReferencePatch> made;
  if (!reference.patch) made = MakeReferencePatch(reference.pixels);
  if (!reference.patch && !made) return std::nullopt;
  const auto tracked =
      TrackPatch(reference.patch ? *reference.patch : *made, frame.image, {start_px, *shape, shape_sigma});
  if (!tracked || tracked->correlation < options_.min_correlation) return std::nullopt;
  const Eigen::Vector2d moved_px = tracked->px - seen.left.px;
  if (!(moved_px.norm() * frame.point_sigma_scale <= kMaxDisagreement * seen.sigma_px)) return std::nullopt;
  StereoPoint point = seen;
  point.left.px = tracked->px;
  // What a patch errs by is much the same in all frames that it is found in.
  point.sigma_px =
      frame.point_sigma_scale * std::hypot(tracked->sigma_px, options_.sigma_px * reference.pixels.size_px);
  if (point.HasDepth()) point.disparity_px += point.disparity_slope.dot(moved_px);
  return point;
}

std::optional<Eigen::Matrix2d> PointRefiner::Shape(const Reference& reference, const Eigen::Vector3d& p_odom,
                                                   const SE3& T_c_odom) const {
  const Eigen::Vector3d p_ref = reference.T_ref_odom * p_odom;
  if (p_ref.z() < camera_.MinDepth()) return std::nullopt;
  const SE3 T_c_ref = T_c_odom * reference.T_ref_odom.Inverse();
  const double arm_px = kArm * reference.pixels.size_px;
  Eigen::Matrix2d shape;
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::Vector2d ends_px[2];
    for (const int side : {0, 1}) {
      const Eigen::Vector2d arm = (side == 0 ? -arm_px : arm_px) * Eigen::Vector2d::Unit(axis);
      const double disparity_px = camera_.FocalBaseline() / p_ref.z() + reference.slope.value.dot(arm);
      if (!(disparity_px > 0.0)) return std::nullopt;
      const Eigen::Vector2d end_px = reference.px + arm;
      const Eigen::Vector3d p_c = T_c_ref * camera_.Backproject({end_px.x(), end_px.y(), disparity_px});
      if (p_c.z() < camera_.MinDepth()) return std::nullopt;
      ends_px[side] = camera_.Project(p_c);
    }
    shape.col(axis) = (ends_px[1] - ends_px[0]) / (2.0 * arm_px);
  }
  return shape;
}

PointRefiner::Slope PointRefiner::SlopeOf(const StereoPoint& seen) {
  Slope slope;
  for (int i = 0; i < 2; ++i) {
    // What was expected before looking is the same each time, and must not count each time.
    const double information = seen.slope_information(i) - kStereoSlopeInformation;
    if (!(information > 0.0)) return {};
    slope.information(i) = information;
    slope.value(i) = seen.disparity_slope(i) * seen.slope_information(i) / information;
  }
  return slope;
}

std::optional<PointRefiner::Slope> PointRefiner::SlopeFrom(const Reference& reference, const StereoPoint& seen,
                                                           const SE3& T_odom_c) const {
  Slope slope = SlopeOf(seen);
  if (!seen.HasDepth() || !(slope.information.minCoeff() > 0.0)) return std::nullopt;
  // The surface is the plane n^T p = 1, and disparities on it change by b n along u and v.
  const Eigen::Vector3d p_c = camera_.Backproject({seen.left.px.x(), seen.left.px.y(), seen.disparity_px});
  Eigen::Vector3d n_c = Eigen::Vector3d::Zero();
  n_c.head<2>() = slope.value / camera_.baseline_m;
  n_c.z() = (1.0 - n_c.dot(p_c)) / p_c.z();
  const SE3 T_ref_c = reference.T_ref_odom * T_odom_c;
  const Eigen::Vector3d normal = T_ref_c.rotation() * n_c.normalized();
  const double distance_m = normal.dot(T_ref_c * p_c);
  if (!(distance_m > kMinPlaneDistance_m)) return std::nullopt;
  slope.value = camera_.baseline_m / distance_m * normal.head<2>();
  if (!(slope.value.cwiseAbs().maxCoeff() < kMaxSlope)) return std::nullopt;
  return slope;
}

void PointRefiner::Learn(const StereoPoint& seen, const SE3& T_odom_c, Reference& reference) const {
  if (const auto slope = SlopeFrom(reference, seen, T_odom_c)) reference.slope.Add(*slope);
  if (!reference.patch) reference.MakePatch();
}

void PointRefiner::Remember(const std::vector<const PointLandmarks*>& alive, const SE3& T_odom_c,
                            const TrackedFrame& frame) {
  if (!options_.enabled || frame.image.empty()) return;
  Forget(alive);
  const SE3 T_c_odom = T_odom_c.Inverse();
  std::vector<Reference> founded;
  for (size_t i = 0; i < frame.point_tracks.size(); ++i) {
    const FeatureTrack& track = frame.point_tracks[i];
    const StereoPoint& seen = frame.features.points[i];
    if (track.landmark_id < 0) continue;
    if (Reference* known = Find(track.landmark_id)) {
      Learn(seen, T_odom_c, *known);
    } else if (track.age == 0) {
      const auto pixels = TakePatch(frame.image, seen.left.px, seen.left.scale);
      if (!pixels) continue;
      Slope slope{Eigen::Vector2d::Zero(), Eigen::Vector2d::Constant(kSlopeInformation)};
      slope.Add(SlopeOf(seen));
      founded.push_back({track.landmark_id, T_c_odom, seen.left.px, *pixels, slope, nullptr});
    }
  }
  std::sort(founded.begin(), founded.end(), Reference::Before);
  const auto middle = static_cast<std::ptrdiff_t>(references_.size());
  std::move(founded.begin(), founded.end(), std::back_inserter(references_));
  std::inplace_merge(references_.begin(), references_.begin() + middle, references_.end(), Reference::Before);
}

void PointRefiner::Forget(const std::vector<const PointLandmarks*>& alive) {
  std::vector<int64_t> ids;
  for (const PointLandmarks* landmarks : alive) {
    for (const PointLandmark& landmark : landmarks->landmarks()) ids.push_back(landmark.id);
  }
  std::sort(ids.begin(), ids.end());
  std::erase_if(references_, [&ids](const Reference& reference) {
    return !std::binary_search(ids.begin(), ids.end(), reference.landmark_id);
  });
}

}  // namespace plslam
