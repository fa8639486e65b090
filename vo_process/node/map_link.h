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

/// A tracker's link to the map of mapping_process: a copy of the map, the newest keyframe of the session in it, and the
/// lockstep wait for it.
///
/// Input: MAP_UPDATE; in lockstep only committed updates take effect, so that results do not depend on timing (except
/// for commands to mapping_process: `on_order`). Output: landmarks of the map for odometry. The wait for a keyframe
/// ends when the map has it, or when mapping_process has not been heard of for `bus.partner_wait_s`.
class MapLink {
 public:
  /// `on_map` is called after each update that takes effect, `on_order` before it if the update changes `localise_only`
  /// or belongs to another map than that with which the session began. `session` must outlive this.
  MapLink(bus::Bus& bus, bool localise_only, const TrackerSession& session, std::function<void()> on_order,
          std::function<void()> on_map);

  const Map& map() const { return subscriber_.follower().map(); }
  /// Whether a map was received; it may have no keyframes.
  bool has_map() const { return subscriber_.follower().version().has_value(); }
  /// Localisation-only mode, in which no keyframes are published: as last changed by mapping_process (committed or
  /// not), initially as configured.
  bool localise_only() const { return localise_only_; }
  /// Whether another map has replaced that with which the session began.
  bool IsOfAnotherMap() const;
  /// As of the last update.
  const MapId& map_id() const { return map_id_; }
  /// Restores the values of a tracker state.
  void Restore(bool localise_only, bool map_is_fixed) {
    localise_only_ = localise_only;
    last_localise_only_ = map_is_fixed;
  }
  /// `MapUpdate::localise_only` of the last update.
  bool map_is_fixed() const { return last_localise_only_.value_or(false); }

  /// Begins a session that has no keyframe in the map yet; `adopted_keyframe_id` is that of a restored tracker.
  void BeginSession(int64_t adopted_keyframe_id = -1);

  /// Whether the map has this keyframe of the session, or a newer one.
  bool Has(int64_t session_keyframe_id) const { return newest_keyframe_id_ >= session_keyframe_id; }
  /// Whether the newest keyframe of the session in the map is connected with the map's first one.
  bool IsConnected() const;
  /// Whether the map has keyframes of other sessions.
  bool HasOthers() const;
  /// Ends a wait for mapping_process that has lasted too long; true if so. Reports that, and a wait that has begun.
  bool GiveUp(double now_s);
  /// Lets odometry adopt the landmarks around the newest keyframe of the session in the map. Returns false if odometry
  /// refuses.
  bool Adopt(Odometry& odometry);
  /// The keyframe around which landmarks were last adopted; -1: none.
  int64_t adopted_keyframe_id() const { return adopted_keyframe_id_; }

  bus::PartnerWait& wait() { return wait_; }
  const bus::PartnerWait& wait() const { return wait_; }

 private:
  void OnUpdate(const MapUpdate& update);

  const TrackerSession& session_;
  std::function<void()> on_order_;
  std::function<void()> on_map_;
  bool localise_only_;
  std::optional<bool> last_localise_only_;  ///< `localise_only` of the last update
  MapId map_id_;
  bus::PartnerWait wait_;
  /// The newest keyframe of the session in the map, which may contain keyframes of other robots.
  int64_t newest_keyframe_id_ = -1;
  int64_t adopted_keyframe_id_ = -1;
  bus::MapSubscriber subscriber_;
};

}  // namespace plslam::vo
