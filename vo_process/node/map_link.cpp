// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/map_link.h"

#include <algorithm>
#include <utility>

namespace plslam::vo {
namespace {

/// Newest keyframe of the session that is in the map, as the session counts; -1: none.
int64_t NewestOf(int64_t session, const Map& map) {
  int64_t newest = -1;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.session == session) newest = std::max(newest, keyframe.session_keyframe_id);
  }
  return newest;
}

}  // namespace

MapLink::MapLink(bus::Bus& bus, double wait_s, const TrackerSession& session, std::function<void()> on_map)
    : session_(session),
      on_map_(std::move(on_map)),
      wait_(wait_s),
      subscriber_(bus, [this](const MapUpdate& update) { OnUpdate(update); }) {}

void MapLink::OnUpdate(const MapUpdate& update) {
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
