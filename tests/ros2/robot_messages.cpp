// SPDX-License-Identifier: BSD-3-Clause
#include "tests/ros2/robot_messages.h"

#include <cmath>
#include <vector>

#include "core/geometry/rectification.h"
#include "core/io/images/jpeg_codec.h"
#include "core/io/images/png_codec.h"

namespace plslam::test {

void SetHeader(std_msgs::msg::dds_::Header_& header, int64_t t_ns, const char* frame) {
  header.stamp().sec(static_cast<int32_t>(t_ns / 1'000'000'000));
  header.stamp().nanosec(static_cast<uint32_t>(t_ns % 1'000'000'000));
  header.frame_id(frame);
}

int64_t StampOf(const std_msgs::msg::dds_::Header_& header) {
  return int64_t{header.stamp().sec()} * 1'000'000'000 + header.stamp().nanosec();
}

sensor_msgs::msg::dds_::Image_ ImageOf(const cv::Mat& grey, int64_t t_ns) {
  sensor_msgs::msg::dds_::Image_ image;
  SetHeader(image.header(), t_ns, "camera");
  image.width(static_cast<uint32_t>(grey.cols));
  image.height(static_cast<uint32_t>(grey.rows));
  image.step(static_cast<uint32_t>(grey.step));
  image.encoding(grey.type() == CV_8UC1 ? "mono8" : "16UC1");
  image.data(std::vector<uint8_t>(grey.datastart, grey.dataend));
  return image;
}

sensor_msgs::msg::dds_::CompressedImage_ CompressedOf(const cv::Mat& image, const std::string& format, int64_t t_ns) {
  constexpr size_t kDepthHeadBytes = 12;
  const bool is_depth = format == "compressedDepth";
  sensor_msgs::msg::dds_::CompressedImage_ message;
  SetHeader(message.header(), t_ns, "camera");
  message.format(is_depth ? "16UC1; compressedDepth png" : "mono8; " + format + " compressed ");
  const std::string file = (is_depth ? std::string(kDepthHeadBytes, '\0') : std::string()) +
                           (format == "jpeg" ? EncodeJpeg(image, 95) : EncodePng(image));
  message.data(std::vector<uint8_t>(file.begin(), file.end()));
  return message;
}

sensor_msgs::msg::dds_::CameraInfo_ InfoOf(const RigCalibration& rig, bool is_left, int64_t t_ns) {
  const Rectification rectified = Rectify(rig);
  const Eigen::Matrix3d left = rectified.q_l_c.toRotationMatrix().transpose();
  const Eigen::Matrix3d right = left * (rig.left.T_b_cam.Inverse() * rig.right.T_b_cam).R();
  const CameraCalibration& c = is_left ? rig.left : rig.right;
  const Eigen::Matrix3d& R = is_left ? left : right;
  const StereoCamera& pair = rectified.camera;
  sensor_msgs::msg::dds_::CameraInfo_ info;
  SetHeader(info.header(), t_ns, "camera");
  info.width(static_cast<uint32_t>(c.width_px));
  info.height(static_cast<uint32_t>(c.height_px));
  info.distortion_model("plumb_bob");
  std::vector<double> distortion = c.distortion;
  distortion.resize(5);
  info.d(distortion);
  info.k({c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1});
  info.r({R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)});
  info.p({pair.f_px, 0, pair.cx_px, is_left ? 0 : -pair.f_px * pair.baseline_m, 0, pair.f_px, pair.cy_px, 0, 0, 0, 1,
          0});
  return info;
}

nav_msgs::msg::dds_::Odometry_ OdometryOf(const SE3& T_first_c, int64_t t_ns) {
  const SE3 T_b_c(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), Eigen::Vector3d::Zero());
  const SE3 T_robot_b = T_b_c * T_first_c * T_b_c.Inverse();
  nav_msgs::msg::dds_::Odometry_ odometry;
  SetHeader(odometry.header(), t_ns, "wheels");
  odometry.child_frame_id("base_link");
  auto& pose = odometry.pose().pose();
  pose.position().x(T_robot_b.translation().x());
  pose.position().y(T_robot_b.translation().y());
  pose.position().z(T_robot_b.translation().z());
  pose.orientation().x(T_robot_b.rotation().x());
  pose.orientation().y(T_robot_b.rotation().y());
  pose.orientation().z(T_robot_b.rotation().z());
  pose.orientation().w(T_robot_b.rotation().w());
  return odometry;
}

sensor_msgs::msg::dds_::Imu_ ImuOf(const ImuSample& sample, int64_t t_ns) {
  sensor_msgs::msg::dds_::Imu_ imu;
  SetHeader(imu.header(), t_ns, "imu_link");
  imu.orientation_covariance()[0] = -1.0;
  imu.angular_velocity().x(sample.rate_rad_s.x());
  imu.angular_velocity().y(sample.rate_rad_s.y());
  imu.angular_velocity().z(sample.rate_rad_s.z());
  imu.linear_acceleration().x(sample.force_m_s2.x());
  imu.linear_acceleration().y(sample.force_m_s2.y());
  imu.linear_acceleration().z(sample.force_m_s2.z());
  return imu;
}

tf2_msgs::msg::dds_::TFMessage_ MountingOf(const RigCalibration& rig) {
  tf2_msgs::msg::dds_::TFMessage_ message;
  message.transforms().resize(rig.imu ? 3 : 2);
  if (rig.imu) {
    const SE3 T = rig.left.T_b_cam.Inverse() * rig.imu->T_b_imu;
    auto& imu = message.transforms()[2];
    SetHeader(imu.header(), 0, "camera");
    imu.child_frame_id("imu_link");
    imu.transform().translation().x(T.translation().x());
    imu.transform().translation().y(T.translation().y());
    imu.transform().translation().z(T.translation().z());
    imu.transform().rotation().x(T.rotation().x());
    imu.transform().rotation().y(T.rotation().y());
    imu.transform().rotation().z(T.rotation().z());
    imu.transform().rotation().w(T.rotation().w());
  }
  auto& mast = message.transforms()[0];
  SetHeader(mast.header(), 0, "base_link");
  mast.child_frame_id("mast");
  mast.transform().translation().x(0.3);
  mast.transform().translation().z(0.2);
  mast.transform().rotation().z(std::sqrt(0.5));
  mast.transform().rotation().w(std::sqrt(0.5));
  auto& optical = message.transforms()[1];
  SetHeader(optical.header(), 0, "mast");
  optical.child_frame_id("camera");
  optical.transform().rotation().x(-0.5);
  optical.transform().rotation().y(0.5);
  optical.transform().rotation().z(-0.5);
  optical.transform().rotation().w(0.5);
  // A tool whose place is not known, before the others.
  message.transforms().emplace(message.transforms().begin());
  auto& tool = message.transforms().front();
  SetHeader(tool.header(), 0, "base_link");
  tool.child_frame_id("tool");
  tool.transform().rotation().w(0.0);
  return message;
}

}  // namespace plslam::test
