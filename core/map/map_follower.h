// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/ids/ids.h"
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

/// Publisher and version of a map that follows its updates.
class MapVersion {
 public:
  /// kNext: the update applies, and this is now that version. kKnown: it was applied before. kGap: versions are
  /// missing, request the complete map.
  enum class Step { kNext, kKnown, kGap };

  /// Accepts an update of another publisher only if it is a complete map.
  Step Advance(const MapUpdate& update);

  SourceId source() const { return source_; }
  /// 0: no update was received.
  int64_t number() const { return number_; }

 private:
  SourceId source_;
  int64_t number_ = 0;
};

/// A copy of a map of another process, kept up to date, and what its updates say about keyframes. `Apply` alone
/// interprets an update.
class MapFollower {
 public:
  /// Relation of the map to the one before the last update that was applied.
  enum class Change {
    kContinued,   ///< the same map
    kRenumbered,  ///< of another mapping_process: ids may mean other keyframes and landmarks
    kReplaced,    ///< another map (`MapUpdate::map_instance`)
  };

  /// A complete map replaces this one.
  MapVersion::Step Apply(const MapUpdate& update);
  /// `Map::RememberRemoved`, until another map replaces this one (`MapUpdate::map_instance`).
  void RememberRemoved() {
    remembers_removed_ = true;
    map_.RememberRemoved();
  }

  const Map& map() const { return map_; }
  SourceId source() const { return version_.source(); }
  int64_t version() const { return version_.number(); }
  Change change() const { return change_; }
  /// Since the last change that was not kContinued.
  const NewestKeyframes& newest() const { return newest_; }

 private:
  void TakeWhole(const MapUpdate& update, bool same_map);
  void TakeChanges(const MapUpdate& update);
  void Move(const std::vector<MovedKeyframe>& keyframes);

  Map map_;
  MapId map_instance_;
  bool remembers_removed_ = false;
  MapVersion version_;
  Change change_ = Change::kContinued;
  NewestKeyframes newest_;
};

}  // namespace plslam
