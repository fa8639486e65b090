// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>

#include "core/ids/ids.h"
#include "core/ids/map_version.h"
#include "core/map/keyframe.h"

namespace plslam::mapping {

/// Which keyframes belong to the map. A session belongs to one map with all its keyframes: also with the first ones,
/// which name none because their tracker had received none.
class MapMembership {
 public:
  enum class Relation {
    kOfThisMap,
    kOfNextMap,  ///< of one that an order put in place of this one (`MapId::Supersedes`)
    kOfOtherMap,
  };

  const MapId& map_id() const { return map_id_; }
  void SetMapId(const MapId& map_id) { map_id_ = map_id; }

  Relation RelationOf(const Keyframe& keyframe) const {
    if (keyframe.map_id.Supersedes(map_id_)) return Relation::kOfNextMap;
    const bool belongs = keyframe.map_id.Matches(map_id_) && !refused_.contains(keyframe.name.session);
    return belongs ? Relation::kOfThisMap : Relation::kOfOtherMap;
  }

  /// Refuses a keyframe of another map. Returns true for the first one of its session.
  bool Refuse(SessionId session) {
    static constexpr size_t kMostSessions = 64;
    ++n_refused_;
    return refused_.size() < kMostSessions && refused_.insert(session).second;
  }
  /// Number of refused keyframes.
  int64_t n_refused() const { return n_refused_; }

 private:
  MapId map_id_;
  std::set<SessionId> refused_;
  int64_t n_refused_ = 0;
};

}  // namespace plslam::mapping
