// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/map_follower.h"

#include <utility>

namespace plslam {
namespace {

void Insert(const MapUpdate& update, Map& map) {
  for (const MapKeyframe& keyframe : update.keyframes) map.Put(keyframe);
  for (const MapPoint& point : update.points) map.Put(point);
  for (const MapLine& line : update.lines) map.Put(line);
  for (const LoopEdge& loop : update.loops) map.Add(loop);
}

}  // namespace

void NewestKeyframes::Add(const MapUpdate& update) {
  // Not the maximum: a rebuilt map begins at the first keyframe.
  if (update.newest.number >= 0) in_map_[update.newest.session] = update.newest.number;
  if (update.committed) committed_ = in_map_;
}

void NewestKeyframes::AddWhole(const MapUpdate& update, const Map& whole) {
  for (const auto& [id, keyframe] : whole.keyframes()) in_map_[keyframe.name.session] = keyframe.name.number;
  Add(update);
}

bool NewestKeyframes::HasCommitted(const KeyframeName& keyframe) const {
  const auto found = committed_.find(keyframe.session);
  return keyframe.number < 0 || (found != committed_.end() && found->second >= keyframe.number);
}

MapStep Advance(const MapUpdate& update, std::optional<MapVersion>& known) {
  const bool same_numbering = known && known->numbering == update.source;
  if (same_numbering && update.version <= known->number) return MapStep::kKnown;
  if (!update.IsWhole() && (!same_numbering || update.base_version != known->number)) return MapStep::kGap;
  known = update.Version();
  return MapStep::kNext;
}

void MapFollower::Move(const std::vector<MovedKeyframe>& keyframes) {
  std::map<KeyframeId, SE3> poses;
  std::map<KeyframeId, Matrix6d> covariances;
  for (const MovedKeyframe& keyframe : keyframes) {
    if (map_.FindKeyframe(keyframe.id) == nullptr) continue;
    poses[keyframe.id] = keyframe.T_w_kf;
    covariances[keyframe.id] = keyframe.covariance;
  }
  map_.Move(poses);
  map_.SetCovariances(covariances);
}

void MapFollower::TakeWhole(const MapUpdate& update, bool same_map) {
  Map whole;
  Insert(update, whole);
  if (same_map) {
    map_.ContinueAs(std::move(whole), update.version);
  } else {
    map_ = std::move(whole);
    if (remembers_removed_) map_.RememberRemoved();
    map_.BeginVersion(update.version);
  }
}

void MapFollower::TakeChanges(const MapUpdate& update) {
  map_.BeginVersion(update.version);
  Move(update.moved_keyframes);
  // Removals first: removing a keyframe reassigns its children, and the update has their final parents.
  for (const LandmarkId id : update.removed_points) map_.RemovePoint(id);
  for (const LandmarkId id : update.removed_lines) map_.RemoveLine(id);
  for (const KeyframeId id : update.removed_keyframes) map_.RemoveKeyframe(id);
  Insert(update, map_);
}

MapStep MapFollower::Apply(const MapUpdate& update) {
  const std::optional<MapVersion> before = version_;
  const MapStep step = Advance(update, version_);
  if (step != MapStep::kNext) return step;
  const bool same_numbering = before && before->numbering == update.source;
  const bool same_map = before && before->map == update.map_id;
  change_ = before && !update.map_id.Matches(before->map) ? Change::kReplaced
            : same_numbering                              ? Change::kContinued
                                                          : Change::kRenumbered;
  if (change_ != Change::kContinued) newest_ = {};
  if (update.IsWhole()) {
    // Without a known origin the map of another process may be another one.
    TakeWhole(update, same_map && (same_numbering || update.map_id.origin != SourceId()));
    newest_.AddWhole(update, map_);
  } else {
    TakeChanges(update);
    newest_.Add(update);
  }
  if (update.camera) map_.SetCamera(*update.camera);
  map_.ForgetChanges();
  return step;
}

}  // namespace plslam
