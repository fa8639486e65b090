// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/map_update.h"

#include <utility>

namespace plslam {
namespace {

template <class Value>
void Copy(const IdMap<Value>& from, const std::vector<int64_t>& ids, std::vector<Value>& to) {
  to.reserve(ids.size());
  for (const int64_t id : ids) to.push_back(from.at(id));
}

template <class Value>
void CopyAll(const IdMap<Value>& from, std::vector<Value>& to) {
  to.reserve(from.size());
  for (const auto& [id, value] : from) to.push_back(value);
}

void Insert(const MapUpdate& update, Map& map) {
  for (const MapKeyframe& keyframe : update.keyframes) map.Put(keyframe);
  for (const MapPoint& point : update.points) map.Put(point);
  for (const MapLine& line : update.lines) map.Put(line);
  for (const LoopEdge& loop : update.loops) map.Add(loop);
}

}  // namespace

MapUpdate ChangedPart(const Map& map, const MapChanges& changes) {
  MapUpdate update;
  update.camera = map.camera();
  update.moved_keyframes = changes.moved_keyframes;
  update.totals = map.Totals();
  Copy(map.keyframes(), changes.keyframes, update.keyframes);
  Copy(map.points(), changes.points, update.points);
  Copy(map.lines(), changes.lines, update.lines);
  update.removed_keyframes = changes.removed_keyframes;
  update.removed_points = changes.removed_points;
  update.removed_lines = changes.removed_lines;
  update.loops = changes.loops;
  return update;
}

MapUpdate WholeMap(const Map& map) {
  MapUpdate update;
  update.camera = map.camera();
  update.totals = map.Totals();
  CopyAll(map.keyframes(), update.keyframes);
  CopyAll(map.points(), update.points);
  CopyAll(map.lines(), update.lines);
  update.loops = map.loops();
  return update;
}

void CommittedKeyframes::Add(const MapUpdate& update) {
  // Not the maximum: a rebuilt map begins at the first keyframe.
  newest_[update.newest.session] = update.newest.number;
  if (update.committed) committed_ = newest_;
}

bool CommittedKeyframes::Has(const KeyframeName& keyframe) const {
  const auto found = committed_.find(keyframe.session);
  return found != committed_.end() && found->second >= keyframe.number;
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

void MapReplica::Move(const std::vector<MovedKeyframe>& keyframes) {
  std::map<int64_t, SE3> poses;
  std::map<int64_t, Matrix6d> covariances;
  for (const MovedKeyframe& keyframe : keyframes) {
    if (map_.FindKeyframe(keyframe.id) == nullptr) continue;
    poses[keyframe.id] = keyframe.T_w_kf;
    covariances[keyframe.id] = keyframe.covariance;
  }
  map_.Move(poses);
  map_.SetCovariances(covariances);
}

MapVersion::Step MapReplica::Apply(const MapUpdate& update) {
  const bool same_source = update.source == version_.source();
  const MapVersion::Step step = version_.Advance(update);
  if (step != MapVersion::Step::kNext) return step;
  const bool same_map = update.map_instance == map_instance_ && (same_source || map_instance_ != 0);
  map_instance_ = update.map_instance;
  if (update.base_version == 0) {
    Map whole;
    Insert(update, whole);
    if (same_map) {
      map_.ContinueAs(std::move(whole), update.version);
    } else {
      map_ = std::move(whole);
      if (remembers_removed_) map_.RememberRemoved();
      map_.BeginVersion(update.version);
    }
  } else {
    map_.BeginVersion(update.version);
    Move(update.moved_keyframes);
    // Removals first: removing a keyframe reassigns its children, and the update has their final parents.
    for (const int64_t id : update.removed_points) map_.RemovePoint(id);
    for (const int64_t id : update.removed_lines) map_.RemoveLine(id);
    for (const int64_t id : update.removed_keyframes) map_.RemoveKeyframe(id);
    Insert(update, map_);
  }
  if (update.camera) map_.SetCamera(*update.camera);
  map_.ForgetChanges();
  return step;
}

}  // namespace plslam
