#include "mapping_process/insertion/sights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/features/matching/hamming.h"
#include "core/features/matching/segment_projection.h"
#include "core/motion/residual.h"

namespace plslam {
namespace {

template <class Kind>
const typename Kind::Feature& FeatureAt(const KeyframeFeatures& features, const Sight& sight) {
  return Kind::Features(features.at(sight.keyframe_id))[static_cast<size_t>(sight.feature)];
}

/// The sight whose descriptor is nearest to all others, the newer one of equals.
template <class Kind>
Sight MostRepresentative(const std::vector<Sight>& sights, const KeyframeFeatures& features) {
  if (sights.size() <= 2) return sights.back();
  std::vector<Descriptor> descriptors;
  descriptors.reserve(sights.size());
  for (const Sight& sight : sights) descriptors.push_back(FeatureAt<Kind>(features, sight).left.descriptor);
  const int n = static_cast<int>(sights.size());
  std::vector<uint16_t> distances(sights.size());
  size_t best = 0;
  int best_sum = std::numeric_limits<int>::max();
  for (size_t i = 0; i < sights.size(); ++i) {
    HammingDistances(descriptors[i], descriptors.data(), n, distances.data());
    const int sum = std::accumulate(distances.begin(), distances.end(), 0);
    if (sum > best_sum) continue;
    best_sum = sum;
    best = i;
  }
  return sights[best];
}

void Represent(const Sight& sight, const KeyframeFeatures& features, const Map& map, MapPoint& point) {
  const StereoPoint& seen = FeatureAt<PointKind>(features, sight);
  point.descriptor = seen.left.descriptor;
  point.angle_rad = seen.left.angle_rad;
  point.octave = seen.left.octave;
  const SE3& T_w_kf = map.FindKeyframe(sight.keyframe_id)->T_w_kf;
  const double depth_m = (T_w_kf.rotation().conjugate() * (point.p_w - T_w_kf.translation())).z();
  if (depth_m > 0.0) point.depth_m = depth_m;
}

void Represent(const Sight& sight, const KeyframeFeatures& features, const Map&, MapLine& line) {
  line.descriptor = FeatureAt<LineKind>(features, sight).left.descriptor;
}

template <class Kind>
void PutWithDescriptor(typename Kind::Landmark landmark, const KeyframeFeatures& features, Map& map) {
  Represent(MostRepresentative<Kind>(landmark.sights, features), features, map, landmark);
  map.Put(std::move(landmark));
}

bool ByKeyframe(const Sight& a, const Sight& b) { return a.keyframe_id < b.keyframe_id; }

}  // namespace

template <class Kind>
bool AddSight(int64_t landmark_id, const Sight& sight, const KeyframeFeatures& features, Map& map) {
  const auto* known = Kind::Find(map, landmark_id);
  if (known == nullptr || IsSeenBy(*known, sight.keyframe_id) || LandmarkAt<Kind>(map, sight) >= 0) return false;
  typename Kind::Landmark landmark = *known;
  landmark.sights.insert(std::upper_bound(landmark.sights.begin(), landmark.sights.end(), sight, ByKeyframe), sight);
  PutWithDescriptor<Kind>(std::move(landmark), features, map);
  return true;
}

template <class Kind>
void DropSight(int64_t landmark_id, int64_t keyframe_id, const KeyframeFeatures& features, Map& map) {
  const auto* known = Kind::Find(map, landmark_id);
  if (known == nullptr) return;
  typename Kind::Landmark landmark = *known;
  std::erase_if(landmark.sights, [keyframe_id](const Sight& sight) { return sight.keyframe_id == keyframe_id; });
  if (landmark.sights.empty()) return Kind::Remove(landmark_id, map);
  PutWithDescriptor<Kind>(std::move(landmark), features, map);
}

template <class Kind>
bool Fuse(int64_t a, int64_t b, const KeyframeFeatures& features, Map& map) {
  const auto* first = Kind::Find(map, std::min(a, b));
  const auto* second = Kind::Find(map, std::max(a, b));
  if (first == nullptr || second == nullptr || first == second) return false;
  for (const Sight& sight : second->sights) {
    if (IsSeenBy(*first, sight.keyframe_id)) return false;
  }
  // The place of the one that more keyframes have seen.
  typename Kind::Landmark fused = first->sights.size() >= second->sights.size() ? *first : *second;
  fused.id = first->id;
  fused.sights = first->sights;
  fused.sights.insert(fused.sights.end(), second->sights.begin(), second->sights.end());
  std::sort(fused.sights.begin(), fused.sights.end(), ByKeyframe);
  Kind::Remove(std::max(a, b), map);
  PutWithDescriptor<Kind>(std::move(fused), features, map);
  return true;
}

template bool AddSight<PointKind>(int64_t, const Sight&, const KeyframeFeatures&, Map&);
template bool AddSight<LineKind>(int64_t, const Sight&, const KeyframeFeatures&, Map&);
template void DropSight<PointKind>(int64_t, int64_t, const KeyframeFeatures&, Map&);
template void DropSight<LineKind>(int64_t, int64_t, const KeyframeFeatures&, Map&);
template bool Fuse<PointKind>(int64_t, int64_t, const KeyframeFeatures&, Map&);
template bool Fuse<LineKind>(int64_t, int64_t, const KeyframeFeatures&, Map&);

namespace {

double Capped(double error) { return error < kMostSightError ? error : kMostSightError; }

// Squared distance across the observed line of one image, in standard deviations.
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

double SightError(const MapPoint& point, const StereoPoint& seen, const SE3& T_kf_w, const StereoCamera& camera) {
  if (IsBehind(point, T_kf_w, camera)) return kMostSightError;
  const Eigen::Vector3d uvd = camera.ProjectStereo(T_kf_w * point.p_w);
  double error = (uvd.head<2>() - seen.left.px).squaredNorm() / (seen.sigma_px * seen.sigma_px);
  if (seen.HasDepth()) error += std::pow((uvd.z() - seen.disparity_px) / seen.sigma_disparity_px, 2);
  return Capped(error);
}

double SightError(const MapLine& line, const StereoLine& seen, const SE3& T_kf_w, const StereoCamera& camera) {
  double error = 0.0;
  for (const Eigen::Vector3d& end_w : {line.segment_w.p, line.segment_w.q}) {
    const Eigen::Vector3d end = T_kf_w * end_w;
    if (!(end.z() > camera.MinDepth())) return kMostSightError;
    const Eigen::Vector3d uvd = camera.ProjectStereo(end);
    error += Across(seen.left.segment, uvd.head<2>(), seen.sigma_px);
    if (!seen.HasDepth()) continue;
    const double sigma_px = std::hypot(seen.sigma_px, std::max(seen.sigma_disparity_p_px, seen.sigma_disparity_q_px));
    error += Across(RightSegment(seen), {uvd.x() - uvd.z(), uvd.y()}, sigma_px);
  }
  return Capped(error);
}

}  // namespace plslam
