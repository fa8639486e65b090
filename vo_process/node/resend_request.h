// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/bus/bus.h"
#include "core/ids/ids.h"
#include "core/run/process_names.h"
#include "vo_process/node/tracker_state.h"

namespace plslam::vo {

/// Request of a restarted tracker to its player for the frames after the newest one it has tracked (`go_back`).
///
/// It is open from `Open` or `Send` until `End`, or until it has been repeated for 15 s without result: a player may
/// have to be started first.
class ResendRequest {
 public:
  explicit ResendRequest(bus::Bus& bus) : bus_(bus) {}

  /// Sets the player: the process that published the last frame or the last status as a player.
  void SetPlayer(SourceId source) { player_ = source; }
  void SetPlayer(SourceId source, const std::string& name);

  bool is_open() const { return opened_s_.has_value(); }
  void Open();
  /// Sends the request, and opens it if it is not open.
  void Send(const TrackerSession& session);
  /// Sends an open request again. Returns whether it has instead ended without result.
  bool RepeatOrEnd(const TrackerSession& session);
  void End() { opened_s_.reset(); }

 private:
  bus::Bus& bus_;
  std::optional<double> opened_s_;  ///< time of `Open`, steady clock
  SourceId player_;
  std::string player_name_ = process_name::kPlayer;  ///< or another process that sends frames
};

}  // namespace plslam::vo
