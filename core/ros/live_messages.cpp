// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/live_messages.h"

#include <utility>
#include <vector>

#include "core/geometry/body_frame.h"
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
  T_b_c_ = BodyFromCamera(rig);
  left_ = rig.left;
  has_static_frame_ = false;
}

void LiveMessages::WriteStaticFrame(int64_t t_ns, const SE3& T_world_map) {
  has_static_frame_ = true;
  if (robot_ && !robot_->writes_camera) return;
  const RosTransform transform = robot_ ? RosTransform{robot_->body, robot_->camera, T_b_c_ * T_c_l_}
                                        : RosTransform{kRosWorld, kRosMap, T_world_map};
  write_(ros_topic::kTfStatic, t_ns, RosTransforms(t_ns, {transform}));
}

void LiveMessages::AddPose(const robot::CameraPose& pose, SessionId session) {
  if (!left_) return;
  if (session != session_) {
    session_ = session;
    path_.clear();
    n_poses_ = 0;
    stride_ = 1;
  }
  if (!has_static_frame_) WriteStaticFrame(pose.t_ns, LevelFromCamera());
  robot_ ? WriteBodyPose(pose) : WriteCameraPose(pose);
}

void LiveMessages::WriteCameraPose(const robot::CameraPose& pose) {
  if (!pose.anchored) return;  // the session is not part of the map yet
  const SE3 T_l_c = T_c_l_.Inverse();
  const Matrix6d to_l = T_l_c.Adjoint();
  RosOdometry odometry;
  odometry.t_ns = pose.t_ns;
  odometry.T_parent_child = pose.T_w_odom * pose.T_odom_c * T_c_l_;
  odometry.covariance = robot::AlongParentAxes(odometry.T_parent_child, to_l * pose.covariance * to_l.transpose());
  if (pose.dt_s) {
    odometry.velocity = (T_l_c * pose.T_prev_c * T_c_l_).Log() / *pose.dt_s;
    odometry.velocity_covariance = to_l * pose.motion_covariance * to_l.transpose() / (*pose.dt_s * *pose.dt_s);
  }
  write_(ros_topic::kTf, pose.t_ns, RosTransforms(pose.t_ns, {{kRosMap, kRosCamera, odometry.T_parent_child}}));
  write_(ros_topic::kOdom, pose.t_ns, RosOdometryMessage(odometry));
  write_(ros_topic::kPose, pose.t_ns,
         RosPoseWithCovariance(pose.t_ns, kRosMap, odometry.T_parent_child, odometry.covariance));
  AddToPath(pose.t_ns, odometry.T_parent_child);
}

void LiveMessages::WriteBodyPose(const robot::CameraPose& pose) {
  const robot::BodyPose body = robot::ToBody(T_b_c_, pose);
  const std::vector<RosTransform> transforms = BodyTransforms(body, *robot_);
  if (!transforms.empty()) write_(ros_topic::kTf, pose.t_ns, RosTransforms(pose.t_ns, transforms));
  write_(ros_topic::kOdom, pose.t_ns, RosOdometryMessage(BodyOdometry(body, *robot_)));
  if (!body.anchored) return;
  write_(ros_topic::kPose, pose.t_ns,
         RosPoseWithCovariance(pose.t_ns, robot_->map, body.T_map_b,
                               robot::AlongParentAxes(body.T_map_odom, body.covariance)));
  AddToPath(pose.t_ns, body.T_map_b);
}

void LiveMessages::AddToPath(int64_t t_ns, const SE3& pose) {
  // The newest pose is always the last one of the path.
  const bool replaces_last = !path_.empty() && (n_poses_ - 1) % stride_ != 0;
  ++n_poses_;
  if (replaces_last) path_.pop_back();
  path_.push_back({t_ns, pose});
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

RosView LiveMessages::View() const { return robot_ ? RosView{robot_->map, T_b_c_} : RosView{}; }

void LiveMessages::WriteMap(const Map& map) {
  if (!left_) return;
  const int64_t t = now_ns();
  const RosView view = View();
  WriteStaticFrame(t, LevelFromMap(map));
  write_(ros_topic::kMapPoints, t, RosPoints(t, map, view));
  write_(ros_topic::kMapLines, t, RosLines(t, map, view));
  write_(ros_topic::kLoops, t, RosLoops(t, map, view));
  Trajectory keyframes;
  for (const auto& [id, keyframe] : map.keyframes()) {
    keyframes.push_back({keyframe.t_ns, robot_ ? T_b_c_ * keyframe.T_w_kf * T_b_c_.Inverse() : keyframe.T_w_kf});
  }
  write_(ros_topic::kKeyframes, t, RosPoseArray(t, view.frame, keyframes));
}

void LiveMessages::WriteGrid(const OccupancyGrid& grid) const {
  if (!left_ || grid.cells.empty()) return;
  write_(ros_topic::kGrid, now_ns(), RosOccupancyGrid(now_ns(), grid, View()));
}

void LiveMessages::WriteSurfaces(const SurfaceCloud& cloud) const {
  if (!left_ || cloud.n_points() == 0) return;
  write_(ros_topic::kSurfaces, now_ns(), RosSurfaces(now_ns(), cloud.PointsInW(), View()));
}

void LiveMessages::WritePath() const {
  if (!path_.empty()) write_(ros_topic::kPath, now_ns(), RosPath(now_ns(), View().frame, path_));
}

void LiveMessages::WriteDiagnostic(RosDiagnostic diagnostic) const {
  diagnostic.t_ns = now_ns();
  write_(ros_topic::kDiagnostics, diagnostic.t_ns, RosDiagnosticMessage(diagnostic));
}

}  // namespace plslam
