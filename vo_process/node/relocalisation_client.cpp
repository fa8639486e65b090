// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/relocalisation_client.h"

#include <utility>

#include "core/bus/channels.h"

namespace plslam::vo {
namespace {

constexpr double kAskAgain_s = 2.0;

}  // namespace

RelocalisationClient::RelocalisationClient(bus::Bus& bus)
    : publisher_(bus, bus::kRelocalisationRequest), wait_(bus.options().partner_wait_s) {}

bool RelocalisationClient::IsDue(bool lockstep, double now_s) const {
  return !request_ || lockstep || now_s - request_->asked_s >= kAskAgain_s;
}

void RelocalisationClient::Ask(Keyframe frame, const SE3& T_odom_c, double now_s) {
  publisher_.Publish(frame);
  const bool waits = frame.lockstep;
  const FrameId frame_id = frame.frame_id;
  request_ = Request{std::move(frame), T_odom_c, now_s};
  if (waits) wait_.Begin(frame_id.value, now_s);
}

std::optional<SE3> RelocalisationClient::Close(const Relocalisation& result, const TrackerSession& session) {
  const bool ours = request_ && result.session == session.id && result.frame_id == request_->frame.frame_id;
  if (!ours) return std::nullopt;
  const SE3 T_w_odom = result.T_w_c * request_->T_odom_c.Inverse();
  End();
  return T_w_odom;
}

void RelocalisationClient::End() {
  wait_.End();
  request_.reset();
}

/// A new loop_process may replace one that exited with the open request: publishes it again.
void RelocalisationClient::OnLoopProcess(SourceId source, double now_s) {
  wait_.OnSignOfLife(now_s);
  const bool is_new = loop_sources_.insert(source).second;
  if (is_new && loop_sources_.size() > 1 && request_ && wait_.awaited()) publisher_.Publish(request_->frame);
}

}  // namespace plslam::vo
