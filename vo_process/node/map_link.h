// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "core/bus/messages/map_channel.h"
#include "core/process/partner_wait.h"
#include "vo_process/node/tracker_state.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {

/// A tracker's link to the map of mapping_process: its copy of the map, how far the map has got with the keyframes of
/// the session, and the lockstep wait for it.
///
/// In: MAP_UPDATE; in lockstep only committed updates count, so that the result does not depend on who is faster (but
/// for what an order of somebody has changed: `on_order`).
/// Out: landmarks of the map for odometry. The wait for a keyframe ends when the map has it, or when mapping_process
/// has not been heard of for `vo.map.wait_s`.
class MapLink {
 public:
  /// `on_map` is called after each update that counts, `on_order` before that where one changes `localise_only` or
  /// is of another map than the session began with. `session` must outlive this.
  MapLink(bus::Bus& bus, double wait_s, bool localise_only, const TrackerSession& session,
          std::function<void()> on_order, std::function<void()> on_map);

  const Map& map() const { return subscriber_.replica().map(); }
  /// Whether a map has come at all; it may have no keyframes.
  bool has_map() const { return subscriber_.replica().version() != 0; }
  /// Whether no keyframes are to be sent: as the owner of the map has last changed it (committed or not), and before
  /// that as begun with.
  bool localise_only() const { return localise_only_; }
  /// Another map has taken the place of the one that the session began with.
  bool IsOfAnotherMap() const;
  /// `MapUpdate::began_version` as last heard.
  int64_t began_version() const { return began_version_; }
  /// As a tracker knows it that goes on with a state.
  void Restore(bool localise_only, bool map_is_fixed) {
    localise_only_ = localise_only;
    said_ = map_is_fixed;
  }
  /// What the map has last said of itself.
  bool map_is_fixed() const { return said_.value_or(false); }

  /// Nothing of another session is in the map yet; `adopted_keyframe_id` as a restarted tracker knows it.
  void BeginSession(int64_t adopted_keyframe_id = -1);

  /// Whether the map has a keyframe of the session, or a newer one.
  bool Has(int64_t session_keyframe_id) const { return newest_keyframe_id_ >= session_keyframe_id; }
  /// Lets odometry take over the landmarks around the newest keyframe of the session in the map. Odometry may refuse;
  /// false then.
  bool Adopt(Odometry& odometry);
  /// The keyframe that landmarks were last taken over around; -1: none.
  int64_t adopted_keyframe_id() const { return adopted_keyframe_id_; }

  bus::PartnerWait& wait() { return wait_; }
  const bus::PartnerWait& wait() const { return wait_; }

 private:
  void OnUpdate(const MapUpdate& update);

  const TrackerSession& session_;
  std::function<void()> on_order_;
  std::function<void()> on_map_;
  bool localise_only_;
  std::optional<bool> said_;  ///< of itself, by the map
  int64_t began_version_ = 0;
  bus::PartnerWait wait_;
  /// The newest keyframe of the session in the map; keyframes of other robots may be in it too.
  int64_t newest_keyframe_id_ = -1;
  int64_t adopted_keyframe_id_ = -1;
  bus::MapSubscriber subscriber_;
};

}  // namespace plslam::vo
