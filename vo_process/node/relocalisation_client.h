// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <set>

#include "core/bus/messages/keyframe_channel.h"
#include "core/map/loop_closure.h"
#include "core/process/partner_wait.h"
#include "vo_process/node/tracker_state.h"

namespace plslam::vo {

/// Asks loop_process where in the map a camera is.
///
/// In: the features of a frame; RELOCALISATION; the life of loop_process. Out: RELOCALISATION_REQUEST. A request is
/// open from `Ask` until its result comes, `Cancel` or `End`. In lockstep the tracker waits for the result, until it
/// comes or loop_process has not been heard of for `vo.relocalisation.wait_s`. A loop_process that was started again
/// gets the open request anew.
class RelocalisationClient {
 public:
  RelocalisationClient(bus::Bus& bus, double wait_s);

  /// Whether to ask about another frame: in real time not while a request is open that is younger than two seconds.
  bool IsDue(bool lockstep, double now_s) const;
  /// Publishes the request; `T_odom_c` is the pose of its frame.
  void Ask(Keyframe frame, const SE3& T_odom_c, double now_s);
  /// Closes the open request with its result and returns T_w_odom as that says, whether or not the camera was found;
  /// nullopt where the result is not of the open request.
  std::optional<SE3> Close(const Relocalisation& result, const TrackerSession& session);
  /// The result of the open request no longer counts.
  void Cancel() { request_.reset(); }
  /// `Cancel`, and nothing is waited for.
  void End();
  /// loop_process lives; `source` is its process.
  void OnLoopProcess(int64_t source, double now_s);

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
  /// All processes that were heard.
  std::set<int64_t> loop_sources_;
};

}  // namespace plslam::vo
