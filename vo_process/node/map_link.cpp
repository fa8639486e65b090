// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/map_link.h"

#include <algorithm>
#include <utility>

namespace plslam::vo {
namespace {

/// Returns the newest keyframe of the session in the map, numbered within the session; -1: none.
int64_t NewestOf(int64_t session, const Map& map) {
  int64_t newest = -1;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.session == session) newest = std::max(newest, keyframe.session_keyframe_id);
  }
  return newest;
}

}  // namespace

MapLink::MapLink(bus::Bus& bus, double wait_s, bool localise_only, const TrackerSession& session,
                 std::function<void()> on_order, std::function<void()> on_map)
    : session_(session),
      on_order_(std::move(on_order)),
      on_map_(std::move(on_map)),
      localise_only_(localise_only),
      wait_(wait_s),
      subscriber_(bus, [this](const MapUpdate& update) { OnUpdate(update); }) {}

/// Version 0: the map of this mapping_process has not replaced another one.
bool MapLink::IsOfAnotherMap() const { return began_version_ != 0 && began_version_ != session_.map_began_version; }

void MapLink::OnUpdate(const MapUpdate& update) {
  began_version_ = update.began_version;
  // A robot configured for localisation only stays so in a map that grows.
  const bool changes = last_localise_only_ ? *last_localise_only_ != update.localise_only : update.localise_only;
  last_localise_only_ = update.localise_only;
  const bool was_localise_only = std::exchange(localise_only_, changes ? update.localise_only : localise_only_);
  if (localise_only_ != was_localise_only || IsOfAnotherMap()) on_order_();
  if (session_.lockstep && !update.committed) return;
  if (update.session == session_.id) {
    newest_keyframe_id_ = update.session_keyframe_id;
  } else if (newest_keyframe_id_ < 0) {
    newest_keyframe_id_ = NewestOf(session_.id, map());
  }
  on_map_();
}

void MapLink::BeginSession(int64_t adopted_keyframe_id) {
  newest_keyframe_id_ = -1;
  adopted_keyframe_id_ = adopted_keyframe_id;
}

bool MapLink::Adopt(Odometry& odometry) {
  if (!odometry.Adopt(map(), session_.id, newest_keyframe_id_)) return false;
  adopted_keyframe_id_ = newest_keyframe_id_;
  return true;
}

}  // namespace plslam::vo
