// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/features/features.h"
#include "core/map/keyframe_features.h"
#include "core/map/map.h"

namespace plslam {

/// Points as a template argument; sibling of `LineType`. Collects the differences between feature types, so that
/// templates can serve both.
struct PointType {
  using Landmark = MapPoint;
  using Feature = StereoPoint;
  static std::span<const StereoPoint> Features(const FeaturesView& features) { return features.points; }
  static const IdMap<LandmarkId, MapPoint>& Landmarks(const Map& map) { return map.points(); }
  static const MapPoint* Find(const Map& map, LandmarkId id) { return map.FindPoint(id); }
  static const std::vector<LandmarkId>& Of(const Map& map, KeyframeId keyframe_id) {
    return map.LandmarksOf(keyframe_id).points;
  }
  static void Remove(LandmarkId id, Map& map) { map.RemovePoint(id); }
};

/// Lines as a template argument; sibling of `PointType`.
struct LineType {
  using Landmark = MapLine;
  using Feature = StereoLine;
  static std::span<const StereoLine> Features(const FeaturesView& features) { return features.lines; }
  static const IdMap<LandmarkId, MapLine>& Landmarks(const Map& map) { return map.lines(); }
  static const MapLine* Find(const Map& map, LandmarkId id) { return map.FindLine(id); }
  static const std::vector<LandmarkId>& Of(const Map& map, KeyframeId keyframe_id) {
    return map.LandmarksOf(keyframe_id).lines;
  }
  static void Remove(LandmarkId id, Map& map) { map.RemoveLine(id); }
};

/// Returns the position of a point, or of the midpoint of a line, in the map.
inline Eigen::Vector3d Middle(const MapPoint& point) { return point.p_w; }
inline Eigen::Vector3d Middle(const MapLine& line) { return 0.5 * (line.segment_w.p + line.segment_w.q); }

/// Returns the landmark of a feature, -1 if there is none.
template <class Type>
LandmarkId LandmarkAt(const Map& map, const Observation& observation) {
  const std::vector<LandmarkId>& of = Type::Of(map, observation.keyframe_id());
  const auto place = static_cast<size_t>(observation.feature);
  return place < of.size() ? of[place] : -1;
}

/// Returns the landmarks observed by any of the keyframes, each once, ascending.
template <class Type>
std::vector<LandmarkId> SeenBy(const std::vector<KeyframeId>& keyframes, const Map& map) {
  std::vector<LandmarkId> ids;
  for (const KeyframeId keyframe_id : keyframes) {
    for (const LandmarkId id : Type::Of(map, keyframe_id)) {
      if (id >= 0) ids.push_back(id);
    }
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

/// Removes the landmarks that the keyframe observes, and negative ids.
template <class Type>
void LeaveOutSeen(KeyframeId keyframe_id, const Map& map, std::vector<LandmarkId>& ids) {
  const std::vector<LandmarkId> seen = SeenBy<Type>({keyframe_id}, map);
  std::erase_if(ids, [&seen](LandmarkId id) { return id < 0 || std::binary_search(seen.begin(), seen.end(), id); });
}

/// Adds to `counts`, by keyframe, how many of the landmarks it observes; ignores negative ids.
template <class Type>
void CountKeyframes(const std::vector<LandmarkId>& landmarks, const Map& map, std::map<KeyframeId, int>& counts) {
  for (const LandmarkId id : landmarks) {
    if (id < 0) continue;
    for (const Observation& observation : Type::Find(map, id)->observations) ++counts[observation.keyframe_id()];
  }
}

/// Returns at most `max_count` of the counted keyframes, by descending count, then by id.
std::vector<KeyframeId> MostCounted(const std::map<KeyframeId, int>& counts, int max_count);

template <class Landmark>
bool IsSeenBy(const Landmark& landmark, KeyframeId keyframe_id) {
  for (const Observation& observation : landmark.observations) {
    if (observation.keyframe_id() == keyframe_id) return true;
  }
  return false;
}

}  // namespace plslam
