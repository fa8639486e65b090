#include "mapping_process/insertion/sights.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "core/features/matching/hamming.h"

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

}  // namespace plslam
