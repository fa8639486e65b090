// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/observations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/features/matching/hamming.h"
#include "core/features/matching/segment_projection.h"
#include "core/geometry/hypot.h"
#include "core/motion/residual.h"

namespace plslam::mapping {
namespace {

template <class Type>
const typename Type::Feature& FeatureAt(const KeyframeFeatures& features, const Observation& observation) {
  return Type::Features(features.at(observation.keyframe_id()))[static_cast<size_t>(observation.feature)];
}

/// Returns the observation with the least sum of descriptor distances to all others, the newer one of equal ones.
template <class Type>
Observation MostRepresentative(const std::vector<Observation>& observations, const KeyframeFeatures& features) {
  if (observations.size() <= 2) return observations.back();
  std::vector<Descriptor> descriptors;
  descriptors.reserve(observations.size());
  for (const Observation& observation : observations)
    descriptors.push_back(FeatureAt<Type>(features, observation).left.descriptor);
  const int n = static_cast<int>(observations.size());
  std::vector<uint16_t> distances(observations.size());
  size_t best = 0;
  int best_sum = std::numeric_limits<int>::max();
  for (size_t i = 0; i < observations.size(); ++i) {
    HammingDistances(descriptors[i], descriptors.data(), n, distances.data());
    const int sum = std::accumulate(distances.begin(), distances.end(), 0);
    if (sum > best_sum) continue;
    best_sum = sum;
    best = i;
  }
  return observations[best];
}

void Represent(const Observation& observation, const KeyframeFeatures& features, const Map& map, MapPoint& point) {
  const StereoPoint& seen = FeatureAt<PointType>(features, observation);
  point.descriptor = seen.left.descriptor;
  point.angle_rad = seen.left.angle_rad;
  point.octave = seen.left.octave;
  const SE3& T_w_kf = map.FindKeyframe(observation.keyframe_id())->T_w_kf;
  const double depth_m = (T_w_kf.rotation().conjugate() * (point.p_w - T_w_kf.translation())).z();
  const std::optional<TakenImage>& image = features.at(observation.keyframe_id()).image;
  const double octave_scale = image ? map.camera()->f_px / image->f_px : 1.0;
  if (depth_m > 0.0) point.depth_m = octave_scale * depth_m;
}

void Represent(const Observation& observation, const KeyframeFeatures& features, const Map&, MapLine& line) {
  line.descriptor = FeatureAt<LineType>(features, observation).left.descriptor;
}

template <class Type>
void PutWithDescriptor(typename Type::Landmark landmark, const KeyframeFeatures& features, Map& map) {
  Represent(MostRepresentative<Type>(landmark.observations, features), features, map, landmark);
  map.Put(std::move(landmark));
}

bool ByKeyframe(const Observation& a, const Observation& b) { return a.keyframe_id() < b.keyframe_id(); }

}  // namespace

template <class Type>
bool AddObservation(LandmarkId landmark_id, const Observation& observation, const KeyframeFeatures& features,
                    Map& map) {
  const auto* known = Type::Find(map, landmark_id);
  if (known == nullptr || IsSeenBy(*known, observation.keyframe_id()) || LandmarkAt<Type>(map, observation) >= 0)
    return false;
  typename Type::Landmark landmark = *known;
  landmark.observations.insert(
      std::upper_bound(landmark.observations.begin(), landmark.observations.end(), observation, ByKeyframe),
      observation);
  PutWithDescriptor<Type>(std::move(landmark), features, map);
  return true;
}

template <class Type>
void DropObservation(LandmarkId landmark_id, KeyframeId keyframe_id, const KeyframeFeatures& features, Map& map) {
  const auto* known = Type::Find(map, landmark_id);
  if (known == nullptr) return;
  typename Type::Landmark landmark = *known;
  std::erase_if(landmark.observations,
                [keyframe_id](const Observation& observation) { return observation.keyframe_id() == keyframe_id; });
  if (landmark.observations.empty()) return Type::Remove(landmark_id, map);
  PutWithDescriptor<Type>(std::move(landmark), features, map);
}

template <class Type>
bool Fuse(LandmarkId a, LandmarkId b, const KeyframeFeatures& features, Map& map) {
  const auto* first = Type::Find(map, std::min(a, b));
  const auto* second = Type::Find(map, std::max(a, b));
  if (first == nullptr || second == nullptr || first == second) return false;
  for (const Observation& observation : second->observations) {
    if (IsSeenBy(*first, observation.keyframe_id())) return false;
  }
  // Keeps the position of the landmark with more observations.
  typename Type::Landmark fused = first->observations.size() >= second->observations.size() ? *first : *second;
  fused.id = first->id;
  fused.observations = first->observations;
  fused.observations.insert(fused.observations.end(), second->observations.begin(), second->observations.end());
  std::sort(fused.observations.begin(), fused.observations.end(), ByKeyframe);
  Type::Remove(std::max(a, b), map);
  PutWithDescriptor<Type>(std::move(fused), features, map);
  return true;
}

template bool AddObservation<PointType>(LandmarkId, const Observation&, const KeyframeFeatures&, Map&);
template bool AddObservation<LineType>(LandmarkId, const Observation&, const KeyframeFeatures&, Map&);
template void DropObservation<PointType>(LandmarkId, KeyframeId, const KeyframeFeatures&, Map&);
template void DropObservation<LineType>(LandmarkId, KeyframeId, const KeyframeFeatures&, Map&);
template bool Fuse<PointType>(LandmarkId, LandmarkId, const KeyframeFeatures&, Map&);
template bool Fuse<LineType>(LandmarkId, LandmarkId, const KeyframeFeatures&, Map&);

namespace {

double Capped(double error) { return error < kMostObservationError ? error : kMostObservationError; }

// Squared distance from the observed line in one image, in variances.
double Across(const Segment2& observed, const Eigen::Vector2d& px, double sigma_px) {
  const double distance_px = LineThrough(observed).dot(px.homogeneous());
  return distance_px * distance_px / VarianceAcross(observed, px, sigma_px);
}

constexpr double kNear_px = 40.0;

}  // namespace

bool IsNear(const MapPoint& point, const StereoPoint& seen, const SE3& T_kf_w, const StereoCamera& camera) {
  if (IsBehind(point, T_kf_w, camera)) return false;
  return (camera.Project(T_kf_w * point.p_w) - seen.left.px).norm() < kNear_px;
}

bool IsNear(const MapLine& line, const StereoLine& seen, const SE3& T_kf_w, const StereoCamera& camera) {
  const auto segment = ClipInFront({T_kf_w * line.segment_w.p, T_kf_w * line.segment_w.q}, camera.MinDepth());
  if (!segment || !(seen.left.segment.Length() > 0.0)) return false;
  const Eigen::Vector2d middle = 0.5 * (seen.left.segment.p + seen.left.segment.q);
  const Segment2 projected{camera.Project(segment->p), camera.Project(segment->q)};
  return projected.Length() > 0.0 && std::abs(LineThrough(projected).dot(middle.homogeneous())) < kNear_px;
}

bool IsBehind(const MapPoint& point, const SE3& T_kf_w, const StereoCamera& camera) {
  return !((T_kf_w * point.p_w).z() > camera.MinDepth());
}

bool IsBehind(const MapLine& line, const SE3& T_kf_w, const StereoCamera& camera) {
  const double least_m = camera.MinDepth();
  return !((T_kf_w * line.segment_w.p).z() > least_m) && !((T_kf_w * line.segment_w.q).z() > least_m);
}

double ObservationError(const MapPoint& point, const StereoPoint& seen, const SE3& T_kf_w,
                        const StereoCamera& camera) {
  if (IsBehind(point, T_kf_w, camera)) return kMostObservationError;
  const Eigen::Vector3d uvd = camera.ProjectStereo(T_kf_w * point.p_w);
  double error = (uvd.head<2>() - seen.left.px).squaredNorm() / (seen.sigma_px * seen.sigma_px);
  if (seen.HasDepth()) error += std::pow((uvd.z() - seen.disparity_px) / seen.sigma_disparity_px, 2);
  return Capped(error);
}

double ObservationError(const MapLine& line, const StereoLine& seen, const SE3& T_kf_w, const StereoCamera& camera) {
  double error = 0.0;
  for (const Eigen::Vector3d& end_w : {line.segment_w.p, line.segment_w.q}) {
    const Eigen::Vector3d end = T_kf_w * end_w;
    if (!(end.z() > camera.MinDepth())) return kMostObservationError;
    const Eigen::Vector3d uvd = camera.ProjectStereo(end);
    error += Across(seen.left.segment, uvd.head<2>(), seen.sigma_px);
    if (!seen.HasDepth()) continue;
    const double sigma_px = Hypot(seen.sigma_px, std::max(seen.sigma_disparity_p_px, seen.sigma_disparity_q_px));
    error += Across(RightSegment(seen), {uvd.x() - uvd.z(), uvd.y()}, sigma_px);
  }
  return Capped(error);
}

}  // namespace plslam::mapping
