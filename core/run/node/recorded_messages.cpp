// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/node/recorded_messages.h"

#include "core/bus/messages/convert.h"

namespace plslam {

std::optional<FramePose> ToFramePose(const pose_t& message) {
  const std::optional<SE3> T_odom_c = bus::FromMessage(message.T_odom_c);
  const std::optional<SE3> T_w_odom = bus::FromMessage(message.T_w_odom);
  const std::optional<Matrix6d> covariance = bus::FromArray(message.covariance);
  const std::optional<Matrix6d> motion_covariance = bus::FromArray(message.motion_covariance);
  if (!T_odom_c || !T_w_odom || !covariance || !motion_covariance) return std::nullopt;
  FramePose pose{.frame_id = FrameId(message.frame_id),
                 .t_ns = message.header.t_ns,
                 .session = SessionId(message.header.session),
                 .state = static_cast<TrackingState>(message.state),
                 .T_odom_c = *T_odom_c,
                 .T_w_odom = *T_w_odom,
                 .anchored = message.anchored != 0,
                 .covariance = *covariance,
                 .motion_covariance = *motion_covariance,
                 .keyframe_id = message.keyframe_id,
                 .entropy_ratio = message.entropy_ratio,
                 .counts = {message.n_points, message.n_lines, message.n_tracked_points, message.n_tracked_lines,
                            message.n_skipped_frames, message.n_moving, message.n_bodies},
                 .stages_ms = {}};
  for (const stage_t& stage : message.stages) pose.stages_ms.emplace_back(stage.name, stage.ms);
  return pose;
}

std::optional<BodiesOfFrame> ToBodiesOfFrame(const bodies_t& message) {
  BodiesOfFrame seen{SessionId(message.header.session), {}};
  for (const body_t& body : message.bodies) {
    const std::optional<SE3> T_c_body = bus::FromMessage(body.T_c_body);
    if (!T_c_body) return std::nullopt;
    seen.bodies.push_back({body.id, *T_c_body, body.n_features});
  }
  return seen;
}

}  // namespace plslam
