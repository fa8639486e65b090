// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/ids/ids.h"
#include "core/ids/map_version.h"
#include "core/map/map.h"
#include "core/map/map_update.h"

namespace plslam {

/// The newest keyframe of each session in a map, and the newest committed one. Several robots may share the map: an
/// update names the newest keyframe of one of them, and a committed update commits all keyframes then in the map.
class NewestKeyframes {
 public:
  /// The head of an update suffices.
  void Add(const MapUpdate& update);
  /// An update that is the complete map, `whole`, which may contain sessions whose updates were missed.
  void AddWhole(const MapUpdate& update, const Map& whole);

  const std::map<SessionId, int64_t>& in_map() const { return in_map_; }
  /// Whether the keyframe, or a later one of its session, is committed. True for none (-1).
  bool HasCommitted(const KeyframeName& keyframe) const;

 private:
  std::map<SessionId, int64_t> in_map_;
  std::map<SessionId, int64_t> committed_;
};

/// Relation of an update to a known version of the map.
enum class MapStep {
  kNext,   ///< the update applies
  kKnown,  ///< it was applied before
  kGap,    ///< versions are missing: request the complete map
};

/// Replaces `known` (nullopt: no update was received) if the update is the next one. An update of another numbering
/// is the next one only if it is a complete map.
MapStep Advance(const MapUpdate& update, std::optional<MapVersion>& known);

/// A copy of a map of another process, kept up to date, and what its updates say about keyframes. `Apply` alone
/// interprets an update.
class MapFollower {
 public:
  /// Relation of the map to the one before the last update that was applied.
  enum class Change {
    kContinued,   ///< the same map
    kRenumbered,  ///< of another mapping_process: ids may mean other keyframes and landmarks
    kReplaced,    ///< another map (`MapId::Matches`)
  };

  /// A complete map replaces this one.
  MapStep Apply(const MapUpdate& update);
  /// `Map::RememberRemoved`, until another map replaces this one.
  void RememberRemoved() {
    remembers_removed_ = true;
    map_.RememberRemoved();
  }

  /// `Map::ForgetRemoved`.
  void ForgetRemoved(const std::set<KeyframeId>& ids) { map_.ForgetRemoved(ids); }

  const Map& map() const { return map_; }
  /// The version of the map; nullopt before the first update.
  const std::optional<MapVersion>& version() const { return version_; }
  Change change() const { return change_; }
  /// Since the last change that was not kContinued.
  const NewestKeyframes& newest() const { return newest_; }

 private:
  void TakeWhole(const MapUpdate& update, bool same_map);
  void TakeChanges(const MapUpdate& update);
  void Move(const std::vector<MovedKeyframe>& keyframes);

  Map map_;
  bool remembers_removed_ = false;
  std::optional<MapVersion> version_;
  Change change_ = Change::kContinued;
  NewestKeyframes newest_;
};

}  // namespace plslam
