// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/map_link.h"

#include <algorithm>
#include <utility>

#include "core/errors/log.h"
#include "core/map/map_graph.h"

namespace plslam::vo {
namespace {

/// Returns the newest keyframe of the session in the map, numbered within the session; -1: none.
int64_t NewestOf(SessionId session, const Map& map) {
  int64_t newest = -1;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.name.session == session) newest = std::max(newest, keyframe.name.number);
  }
  return newest;
}

}  // namespace

MapLink::MapLink(bus::Bus& bus, bool localise_only, const TrackerSession& session, std::function<void()> on_order,
                 std::function<void()> on_map)
    : session_(session),
      on_order_(std::move(on_order)),
      on_map_(std::move(on_map)),
      localise_only_(localise_only),
      wait_(bus.options().partner_wait_s),
      subscriber_(bus, [this](const MapUpdate& update) { OnUpdate(update); }) {}

bool MapLink::IsOfAnotherMap() const { return !session_.map_id.Matches(map_id_); }

bool MapLink::IsConnected() const {
  const IdMap<KeyframeId, MapKeyframe>& keyframes = map().keyframes();
  const auto is_newest = [&](const auto& entry) {
    return entry.second.name == KeyframeName{session_.id, newest_keyframe_id_};
  };
  const auto newest = std::find_if(keyframes.rbegin(), keyframes.rend(), is_newest);
  if (newest == keyframes.rend()) return false;
  const KeyframeId first = keyframes.begin()->first;
  return newest->first == first || MapGraph(map()).Component(newest->first, MapGraph::Edges::kAll).contains(first);
}

bool MapLink::HasOthers() const {
  return std::ranges::any_of(map().keyframes(), [&](const auto& k) { return k.second.name.session != session_.id; });
}

void MapLink::OnUpdate(const MapUpdate& update) {
  map_id_ = update.map_id;
  // A robot configured for localisation only stays so in a map that grows.
  const bool changes = last_localise_only_ ? *last_localise_only_ != update.localise_only : update.localise_only;
  last_localise_only_ = update.localise_only;
  const bool was_localise_only = std::exchange(localise_only_, changes ? update.localise_only : localise_only_);
  if (localise_only_ != was_localise_only || IsOfAnotherMap()) on_order_();
  if (session_.lockstep && !update.committed) return;
  if (update.newest.session == session_.id) {
    newest_keyframe_id_ = update.newest.number;
  } else if (newest_keyframe_id_ < 0) {
    newest_keyframe_id_ = NewestOf(session_.id, map());
  }
  on_map_();
}

void MapLink::BeginSession(int64_t adopted_keyframe_id) {
  newest_keyframe_id_ = -1;
  adopted_keyframe_id_ = adopted_keyframe_id;
}

bool MapLink::GiveUp(double now_s) {
  if (wait_.NoticeSilence(now_s)) {
    LogWarning("waiting up to {:.0f} s for mapping_process, which is not found (bus.partner_wait_s)", wait_.wait_s());
  }
  const bool given_up = wait_.GiveUp(now_s);
  if (given_up) LogWarning("no mapping_process is found: continuing as odometry");
  return given_up;
}

bool MapLink::Adopt(Odometry& odometry) {
  if (!odometry.Adopt(map(), {session_.id, newest_keyframe_id_})) return false;
  adopted_keyframe_id_ = newest_keyframe_id_;
  return true;
}

}  // namespace plslam::vo
