// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <set>

#include "core/bus/messages/keyframe_channel.h"
#include "core/ids/ids.h"
#include "core/map/loop_closure.h"
#include "core/process/partner_wait.h"
#include "vo_process/node/tracker_state.h"

namespace plslam::vo {

/// Requests relocalisation from loop_process.
///
/// Inputs: the features of a frame, RELOCALISATION, status of loop_process. Output: RELOCALISATION_REQUEST. A request
/// is open from `Ask` until its result arrives, `Cancel` or `End`. In lockstep the tracker waits until the result
/// arrives, or loop_process has not been heard of for `bus.partner_wait_s`. The open request is resent to a
/// restarted loop_process.
class RelocalisationClient {
 public:
  explicit RelocalisationClient(bus::Bus& bus);

  /// Whether a new request may be sent: in real time not while one is open that is younger than two seconds.
  bool IsDue(bool lockstep, double now_s) const;
  /// Publishes the request; `T_odom_c` is the pose of its frame.
  void Ask(Keyframe frame, const SE3& T_odom_c, double now_s);
  /// Closes the open request with its result and returns the resulting T_w_odom, whether or not the camera was found;
  /// nullopt if the result does not answer the open request.
  std::optional<SE3> Close(const Relocalisation& result, const TrackerSession& session);
  /// Discards the open request, so that its result is ignored.
  void Cancel() { request_.reset(); }
  /// `Cancel`, and ends the wait.
  void End();
  /// loop_process is alive; `source` is its process.
  void OnLoopProcess(SourceId source, double now_s);

  bus::PartnerWait& wait() { return wait_; }
  const bus::PartnerWait& wait() const { return wait_; }

 private:
  struct Request {
    Keyframe frame;
    SE3 T_odom_c;
    double asked_s = 0.0;
  };

  bus::KeyframePublisher publisher_;
  bus::PartnerWait wait_;
  std::optional<Request> request_;
  /// All loop processes heard of so far.
  std::set<SourceId> loop_sources_;
};

}  // namespace plslam::vo
