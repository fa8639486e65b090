// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/corrections/loop_fusion.h"

#include <algorithm>
#include <map>

#include "mapping_process/insertion/duplicates.h"
#include "mapping_process/insertion/observations.h"

namespace plslam::mapping {
namespace {

// Keyframes of each side: neighbours see landmarks that the two ends of the loop do not see.
constexpr size_t kSide = 10;
// The pose graph aligns keyframes only, so landmarks of the two sides agree less well than those of neighbours.
constexpr double kRadius = 2.0;  // relative to the radius for neighbours

// Breadth-first over neighbours, the best of each keyframe first.
std::vector<KeyframeId> Around(KeyframeId keyframe_id, int min_shared, const Map& map) {
  std::vector<KeyframeId> ids{keyframe_id};
  for (size_t i = 0; i < ids.size(); ++i) {
    for (const Map::Neighbour& neighbour : map.Neighbours(ids[i], min_shared)) {
      if (ids.size() == kSide) return ids;
      if (std::find(ids.begin(), ids.end(), neighbour.keyframe_id) == ids.end()) ids.push_back(neighbour.keyframe_id);
    }
  }
  return ids;
}

template <class Type>
void FuseType(const std::vector<SameLandmarks>& pairs, const KeyframeFeatures& features, Map& map) {
  std::map<LandmarkId, LandmarkId> became;
  const auto now = [&became](LandmarkId id) {
    for (auto next = became.find(id); next != became.end(); next = became.find(id)) id = next->second;
    return id;
  };
  for (const SameLandmarks& pair : pairs) {
    const LandmarkId a = now(pair.a);
    const LandmarkId b = now(pair.b);
    if (Fuse<Type>(a, b, features, map)) became[std::max(a, b)] = std::min(a, b);
  }
}

void MergeOneWay(const std::vector<KeyframeId>& to, const std::vector<KeyframeId>& from,
                 const KeyframeFeatures& features, const StereoCamera& camera, const MappingOptions& options,
                 Map& map) {
  const double radius_px = kRadius * options.insertion.fuse_radius_px;
  for (const KeyframeId keyframe_id : to) {
    LocalMap landmarks{SeenBy<PointType>(from, map), SeenBy<LineType>(from, map)};
    LeaveOutSeen<PointType>(keyframe_id, map, landmarks.points);
    LeaveOutSeen<LineType>(keyframe_id, map, landmarks.lines);
    MergeInto(keyframe_id, landmarks, {radius_px, radius_px}, features, camera, options.localisation, map);
  }
}

// Choosing an older parent avoids cycles in the spanning tree.
void Reparent(KeyframeId keyframe_id, Map& map) {
  MapKeyframe keyframe = *map.FindKeyframe(keyframe_id);
  if (keyframe.parent_id >= 0) return;
  for (const Map::Neighbour& neighbour : map.Neighbours(keyframe_id, Map::kParent)) {
    if (neighbour.keyframe_id >= keyframe_id) continue;
    keyframe.parent_id = neighbour.keyframe_id;
    return map.Put(keyframe);
  }
}

}  // namespace

LoopSides SidesOf(const LoopEdge& edge, int min_shared, const Map& map) {
  if (map.FindKeyframe(edge.old_keyframe_id) == nullptr || map.FindKeyframe(edge.keyframe_id) == nullptr) return {};
  LoopSides sides{Around(edge.old_keyframe_id, min_shared, map), Around(edge.keyframe_id, min_shared, map)};
  std::erase_if(sides.new_side, [&sides](KeyframeId id) {
    return std::find(sides.old_side.begin(), sides.old_side.end(), id) != sides.old_side.end();
  });
  return sides;
}

void FusePairs(const std::vector<SameLandmarks>& points, const std::vector<SameLandmarks>& lines,
               const KeyframeFeatures& features, Map& map) {
  FuseType<PointType>(points, features, map);
  FuseType<LineType>(lines, features, map);
}

void MergeSides(const LoopSides& sides, const KeyframeFeatures& features, const StereoCamera& camera,
                const MappingOptions& options, Map& map) {
  MergeOneWay(sides.new_side, sides.old_side, features, camera, options, map);
  MergeOneWay(sides.old_side, sides.new_side, features, camera, options, map);
  for (const std::vector<KeyframeId>* side : {&sides.new_side, &sides.old_side}) {
    for (const KeyframeId id : *side) Reparent(id, map);
  }
}

}  // namespace plslam::mapping
