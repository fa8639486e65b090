// SPDX-License-Identifier: BSD-3-Clause
#include "core/localisation/pose_refinement.h"

#include "core/features/matching/descriptor_matcher.h"
#include "core/features/matching/hamming.h"
#include "core/features/matching/line_matcher.h"
#include "core/geometry/triangulation.h"
#include "core/motion/pose_ransac.h"

namespace plslam {
namespace {

// Correspondences relative to the predicted pose of the keyframe, and the indices of their features.
struct Observed {
  std::vector<PointCorrespondence> points;
  std::vector<LineCorrespondence> lines;
  std::vector<size_t> point_features;
  std::vector<size_t> line_features;
};

void ObservePoints(const Map& map, std::span<const StereoPoint> features, const SE3& T_ref_w,
                   const std::vector<LandmarkId>& association, Observed& observed) {
  const Eigen::Matrix3d R = T_ref_w.R();
  for (size_t i = 0; i < association.size(); ++i) {
    if (association[i] < 0) continue;
    const MapPoint& point = *map.FindPoint(association[i]);
    observed.points.push_back(ObservationOf(T_ref_w * point.p_w, RotateCovariance(R, point.covariance), features[i]));
    observed.point_features.push_back(i);
  }
}

void ObserveLines(const Map& map, std::span<const StereoLine> features, const SE3& T_ref_w,
                  const std::vector<LandmarkId>& association, Observed& observed) {
  const Eigen::Matrix3d R = T_ref_w.R();
  for (size_t i = 0; i < association.size(); ++i) {
    if (association[i] < 0) continue;
    const MapLine& line = *map.FindLine(association[i]);
    observed.lines.push_back(ObservationOf({T_ref_w * line.segment_w.p, T_ref_w * line.segment_w.q},
                                           RotateCovariance(R, line.covariance_p),
                                           RotateCovariance(R, line.covariance_q), features[i]));
    observed.line_features.push_back(i);
  }
}

Observed Observe(const Map& map, const FeaturesView& features, const SE3& T_ref_w, const Association& association) {
  Observed observed;
  ObservePoints(map, features.points, T_ref_w, association.points, observed);
  ObserveLines(map, features.lines, T_ref_w, association.lines, observed);
  return observed;
}

// Inlier threshold in the image for matches by descriptor alone; the refinement narrows it.
constexpr double kRecognised_px = 4.0;
constexpr uint64_t kSeed = 1;

template <class Type>
std::vector<Descriptor> DescriptorsOf(const Map& map, const std::vector<LandmarkId>& ids) {
  std::vector<Descriptor> descriptors;
  descriptors.reserve(ids.size());
  for (const LandmarkId id : ids) descriptors.push_back(Type::Find(map, id)->descriptor);
  return descriptors;
}

std::vector<LandmarkId> Named(const std::vector<int>& match, const std::vector<LandmarkId>& ids) {
  std::vector<LandmarkId> named;
  named.reserve(match.size());
  for (const int place : match) named.push_back(place < 0 ? -1 : ids[static_cast<size_t>(place)]);
  return named;
}

}  // namespace

PointCorrespondence ObservationOf(const Eigen::Vector3d& p_ref, const Eigen::Matrix3d& covariance,
                                  const StereoPoint& seen) {
  return {p_ref,
          covariance,
          {seen.left.px.x(), seen.left.px.y(), seen.disparity_px},
          seen.sigma_px,
          seen.sigma_disparity_px};
}

LineCorrespondence ObservationOf(const Segment3& segment_ref, const Eigen::Matrix3d& covariance_p,
                                 const Eigen::Matrix3d& covariance_q, const StereoLine& seen) {
  return {segment_ref,
          covariance_p,
          covariance_q,
          seen.left.segment,
          seen.disparity_p_px,
          seen.disparity_q_px,
          seen.sigma_px,
          seen.sigma_disparity_p_px,
          seen.sigma_disparity_q_px};
}

std::optional<KeyframePose> RefinePose(const Map& map, const FeaturesView& features, const StereoCamera& camera,
                                       const SE3& T_w_kf, const MotionOptions& options, Association& association) {
  const Observed observed = Observe(map, features, T_w_kf.Inverse(), association);
  const auto estimate = EstimateMotion(observed.points, observed.lines, camera, SE3(), std::nullopt, options);
  if (!estimate) return std::nullopt;
  for (size_t i = 0; i < observed.points.size(); ++i) {
    if (!estimate->point_inliers[i]) association.points[observed.point_features[i]] = -1;
  }
  for (size_t i = 0; i < observed.lines.size(); ++i) {
    if (!estimate->line_inliers[i]) association.lines[observed.line_features[i]] = -1;
  }
  return KeyframePose{T_w_kf * estimate->T_cur_ref.Inverse(), estimate->covariance};
}

std::optional<KeyframePose> FindPose(const Map& map, const FeaturesView& features, const StereoCamera& camera,
                                     const MotionOptions& options, int min_weight, Association& association) {
  const Observed observed = Observe(map, features, SE3(), association);
  const auto T_kf_w = EstimatePoseRansac(observed.points, observed.lines, camera, min_weight, kRecognised_px, kSeed);
  if (!T_kf_w) return std::nullopt;
  Association found = association;
  auto pose = RefinePose(map, features, camera, T_kf_w->Inverse(), options, found);
  if (!pose || found.Weight() < min_weight) return std::nullopt;
  association = found;
  return pose;
}

std::optional<KeyframePose> RecognisePose(const Map& map, const LocalMap& local, const FeaturesView& features,
                                          const StereoCamera& camera, const LocalisationOptions& options,
                                          int min_weight, Association& association) {
  Association found;
  found.points = Named(MatchBruteForce(DescriptorsOf(features.points), DescriptorsOf<PointType>(map, local.points),
                                       options.point_matching),
                       local.points);
  found.lines = Named(MatchLinesBruteForce(DescriptorsOf(features.lines), DescriptorsOf<LineType>(map, local.lines),
                                           options.line_matching),
                      local.lines);
  auto pose = FindPose(map, features, camera, options.motion, min_weight, found);
  if (pose) association = found;
  return pose;
}

}  // namespace plslam
