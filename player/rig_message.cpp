#include "player/rig_message.h"

namespace plslam {
namespace {

intrinsics_t ToMessage(const CameraCalibration& camera) {
  intrinsics_t message;
  message.width_px = camera.width_px;
  message.height_px = camera.height_px;
  message.model = camera.model;
  message.fx_px = camera.fx_px;
  message.fy_px = camera.fy_px;
  message.cx_px = camera.cx_px;
  message.cy_px = camera.cy_px;
  message.distortion = camera.distortion;
  message.n_distortion = static_cast<int32_t>(camera.distortion.size());
  message.T_b_cam = ToMessage(camera.T_b_cam);
  return message;
}

}  // namespace

pose3_t ToMessage(const SE3& T) {
  const Eigen::Vector3d& t = T.translation();
  const Eigen::Quaterniond& q = T.rotation();
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  return {{t.x(), t.y(), t.z()}, {sign * q.w(), sign * q.x(), sign * q.y(), sign * q.z()}};
}

camera_t ToMessage(const RigCalibration& rig) {
  camera_t message;
  message.header = {};
  message.rig_name = rig.name;
  message.kind = rig.kind == RigCalibration::Kind::kRgbd ? "rgbd" : "stereo";
  message.rate_hz = rig.rate_hz;
  message.left = ToMessage(rig.left);
  message.right = ToMessage(rig.right);
  message.depth_units_per_m = rig.depth_units_per_m;
  message.baseline_m = rig.baseline_m;
  return message;
}

}  // namespace plslam
