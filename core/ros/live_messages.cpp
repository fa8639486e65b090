// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/live_messages.h"

#include <utility>

#include "core/geometry/rectification.h"
#include "core/io/images/jpeg_codec.h"
#include "core/ros/level_frame.h"

namespace plslam {
namespace {

constexpr int kJpegQuality = 80;
constexpr size_t kMostPathPoses = 10'000;

}  // namespace

void LiveMessages::SetRig(const RigCalibration& rig) {
  T_c_l_ = SE3(Rectify(rig).q_l_c.conjugate(), Eigen::Vector3d::Zero());
  left_ = rig.left;
}

void LiveMessages::AddPose(const LivePose& pose) {
  if (!left_) return;
  const SE3 T_l_c = T_c_l_.Inverse();
  const Matrix6d to_l = T_l_c.Adjoint();
  RosOdometry odometry{pose.t_ns, pose.T_w_c * T_c_l_};
  odometry.covariance = to_l * pose.covariance * to_l.transpose();
  if (pose.dt_s) {
    odometry.velocity = (T_l_c * pose.T_prev_c * T_c_l_).Log() / *pose.dt_s;
    odometry.velocity_covariance = to_l * pose.motion_covariance * to_l.transpose() / (*pose.dt_s * *pose.dt_s);
  }
  write_(ros_topic::kTf, pose.t_ns, RosTransform(pose.t_ns, kRosMap, kRosCamera, odometry.T_w_l));
  write_(ros_topic::kOdom, pose.t_ns, RosOdometryMessage(odometry));

  if (pose.session != session_) {
    session_ = pose.session;
    path_.clear();
    n_poses_ = 0;
    stride_ = 1;
  }
  // The newest pose is always the last one of the path.
  const bool replaces_last = !path_.empty() && (n_poses_ - 1) % stride_ != 0;
  ++n_poses_;
  if (replaces_last) path_.pop_back();
  path_.push_back({pose.t_ns, odometry.T_w_l});
  if (path_.size() <= kMostPathPoses) return;
  for (size_t i = 0; 2 * i < path_.size(); ++i) path_[i] = path_[2 * i];
  path_.resize((path_.size() + 1) / 2);
  stride_ *= 2;
}

void LiveMessages::WriteImage(int64_t t_ns, const cv::Mat& left) const {
  if (!left_) return;
  write_(ros_topic::kLeftImage, t_ns, RosCompressedImage(t_ns, "jpeg", EncodeJpeg(left, kJpegQuality)));
  write_(ros_topic::kLeftInfo, t_ns, RosCameraInfoMessage(t_ns, *left_));
}

void LiveMessages::WriteMap(const Map& map) const {
  const int64_t t = now_ns();
  write_(ros_topic::kTfStatic, t, RosTransform(t, kRosWorld, kRosMap, LevelFromMap(map)));
  write_(ros_topic::kMapPoints, t, RosPoints(t, map));
  write_(ros_topic::kMapLines, t, RosLines(t, map));
  write_(ros_topic::kLoops, t, RosLoops(t, map));
  Trajectory keyframes;
  for (const auto& [id, keyframe] : map.keyframes()) keyframes.push_back({keyframe.t_ns, keyframe.T_w_kf});
  write_(ros_topic::kKeyframes, t, RosPoseArray(t, keyframes));
}

void LiveMessages::WritePath() const {
  if (!path_.empty()) write_(ros_topic::kPath, now_ns(), RosPath(now_ns(), path_));
}

void LiveMessages::WriteDiagnostic(RosDiagnostic diagnostic) const {
  diagnostic.t_ns = now_ns();
  write_(ros_topic::kDiagnostics, diagnostic.t_ns, RosDiagnosticMessage(diagnostic));
}

}  // namespace plslam
