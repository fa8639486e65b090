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

MapVersion::Step MapVersion::Advance(const MapUpdate& update) {
  const bool same_source = update.source == source_;
  if (same_source && update.version <= number_) return Step::kKnown;
  const bool whole = update.base_version == 0;
  if (!whole && (!same_source || update.base_version != number_)) return Step::kGap;
  source_ = update.source;
  number_ = update.version;
  return Step::kNext;
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

MapVersion::Step MapFollower::Apply(const MapUpdate& update) {
  const bool same_source = update.source == version_.source();
  const MapVersion::Step step = version_.Advance(update);
  if (step != MapVersion::Step::kNext) return step;
  const bool same_instance = update.map_instance == map_instance_;
  const bool same_map = same_instance && (same_source || map_instance_ != 0);
  change_ = update.map_instance != 0 && !same_instance ? Change::kReplaced
            : same_source                              ? Change::kContinued
                                                       : Change::kRenumbered;
  map_instance_ = update.map_instance;
  if (change_ != Change::kContinued) newest_ = {};
  if (update.base_version == 0) {
    TakeWhole(update, same_map);
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
