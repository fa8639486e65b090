// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/culling.h"

#include <algorithm>
#include <utility>

#include "core/map/map_graph.h"
#include "mapping_process/insertion/loop_edges.h"

namespace plslam::mapping {
namespace {

template <class Type>
void CheckFeatureType(const std::vector<LandmarkId>& ids, int min_observations, Map& map) {
  for (const LandmarkId id : ids) {
    const auto* landmark = Type::Find(map, id);
    if (landmark != nullptr && static_cast<int>(landmark->observations.size()) < min_observations)
      Type::Remove(id, map);
  }
}

struct Share {
  int landmarks = 0;
  int redundant = 0;
};

template <class Type>
void CountRedundant(KeyframeId keyframe_id, int min_others, const Map& map, Share& share) {
  for (const LandmarkId id : Type::Of(map, keyframe_id)) {
    if (id < 0) continue;
    ++share.landmarks;
    if (static_cast<int>(Type::Find(map, id)->observations.size()) > min_others) ++share.redundant;
  }
}

// The loop would be less certain between other keyframes.
bool IsEndOfLoop(KeyframeId id, const Map& map) {
  return std::ranges::any_of(map.loops(), [id](const LoopEdge& loop) { return loop.EndsAt(id); });
}

bool IsRedundant(const MapKeyframe& keyframe, const CullingOptions& options, const Map& map) {
  if (keyframe.previous_id < 0 || keyframe.id == map.keyframes().begin()->first) return false;
  if (IsEndOfLoop(keyframe.id, map)) return false;
  Share share;
  CountRedundant<PointType>(keyframe.id, options.redundant_observations, map, share);
  CountRedundant<LineType>(keyframe.id, options.redundant_observations, map, share);
  return share.landmarks > 0 && share.redundant >= options.redundant_share * share.landmarks;
}

// Connects the successor of a removed keyframe with its predecessor.
void BridgeOver(KeyframeId id, Map& map) {
  const MapKeyframe* const found = NextInSession(id, map);
  if (found == nullptr) return;
  const MapKeyframe gone = *map.FindKeyframe(id);
  MapKeyframe next = *found;
  next.previous_id = gone.previous_id;
  const bool begins = gone.previous_id < 0;
  next.relative_covariance =
      begins ? Matrix6d(Matrix6d::Zero())
             : ComposeCovariance(gone.relative_covariance, next.T_prevkf_kf, next.relative_covariance);
  next.T_prevkf_kf = begins ? SE3() : gone.T_prevkf_kf * next.T_prevkf_kf;
  map.Put(next);
}

}  // namespace

void RecentLandmarks::Begin(const NewLandmarks& landmarks, SessionId session) {
  Session& of = sessions_[session];
  of.by_keyframe[++of.begun] = landmarks;
}

void RecentLandmarks::Cull(const CullingOptions& options, const Visits& visits, Map& map) {
  for (auto& [id, session] : sessions_) {
    auto& by_keyframe = session.by_keyframe;
    const int64_t recent = visits.Has(id) ? options.recent_keyframes : 0;
    while (!by_keyframe.empty() && by_keyframe.begin()->first + recent <= session.begun) {
      const NewLandmarks due = std::exchange(by_keyframe.begin()->second, {});
      by_keyframe.erase(by_keyframe.begin());
      CheckFeatureType<PointType>(due.points, options.min_observations, map);
      CheckFeatureType<LineType>(due.lines, options.min_observations, map);
    }
  }
  std::erase_if(sessions_, [&visits](const auto& session) { return !visits.Has(session.first); });
}

void TakeOut(KeyframeId keyframe_id, KeyframeFeatures& features, Map& map) {
  const PassedOnLoops loops = LoopsPassedOn(keyframe_id, map);
  BridgeOver(keyframe_id, map);
  map.RemoveKeyframe(keyframe_id);
  AddNeeded(loops, map);
  features.erase(keyframe_id);
}

std::vector<KeyframeId> RemoveRedundantKeyframes(const std::vector<KeyframeId>& candidates,
                                                 const CullingOptions& options, KeyframeFeatures& features,
                                                 Map& map) {
  std::vector<KeyframeId> removed;
  for (const KeyframeId id : candidates) {
    const MapKeyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr || !IsRedundant(*keyframe, options, map)) continue;
    TakeOut(id, features, map);
    removed.push_back(id);
  }
  return removed;
}

}  // namespace plslam::mapping
