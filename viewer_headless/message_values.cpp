#include "viewer_headless/message_values.h"

namespace plslam {
namespace {

CameraCalibration ToCamera(const intrinsics_t& message) {
  CameraCalibration camera;
  camera.width_px = message.width_px;
  camera.height_px = message.height_px;
  camera.model = message.model;
  camera.fx_px = message.fx_px;
  camera.fy_px = message.fy_px;
  camera.cx_px = message.cx_px;
  camera.cy_px = message.cy_px;
  camera.distortion = message.distortion;
  camera.T_b_cam = ToSe3(message.T_b_cam);
  return camera;
}

Matrix6d ToMatrix(const double (&row_major)[36]) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(row_major);
}

}  // namespace

SE3 ToSe3(const pose3_t& message) {
  const double* q = message.q_wxyz;
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]),
          Eigen::Vector3d(message.position_m[0], message.position_m[1], message.position_m[2])};
}

RigCalibration ToRig(const camera_t& message) {
  RigCalibration rig;
  rig.name = message.rig_name;
  rig.kind = message.kind == "rgbd" ? RigCalibration::Kind::kRgbd : RigCalibration::Kind::kStereo;
  rig.rate_hz = message.rate_hz;
  rig.left = ToCamera(message.left);
  rig.right = ToCamera(message.right);
  rig.depth_units_per_m = message.depth_units_per_m;
  rig.baseline_m = message.baseline_m;
  return rig;
}

FramePose ToFramePose(const pose_t& message) {
  FramePose pose;
  pose.frame_id = message.frame_id;
  pose.t_ns = message.header.t_ns;
  pose.session = message.header.session;
  pose.state = static_cast<TrackingState>(message.state);
  pose.T_odom_c = ToSe3(message.T_odom_c);
  pose.T_w_odom = ToSe3(message.T_w_odom);
  pose.covariance = ToMatrix(message.covariance);
  pose.motion_covariance = ToMatrix(message.motion_covariance);
  pose.keyframe_id = message.keyframe_id;
  pose.entropy_ratio = message.entropy_ratio;
  pose.counts = {message.n_points, message.n_lines, message.n_tracked_points, message.n_tracked_lines,
                 message.n_skipped_frames};
  for (const stage_t& stage : message.stages) pose.stages_ms.emplace_back(stage.name, stage.ms);
  return pose;
}

OverlayFeatures ToOverlayFeatures(const tracks_t& message) {
  OverlayFeatures features;
  for (const track_point_t& p : message.points) features.points.push_back({{p.u_px, p.v_px}, p.disparity_px, p.age});
  for (const track_line_t& l : message.lines) {
    features.segments.push_back({{l.p_px[0], l.p_px[1]}, {l.q_px[0], l.q_px[1]}, l.has_depth != 0, l.age});
  }
  return features;
}

}  // namespace plslam
