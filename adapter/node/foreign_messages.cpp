// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/foreign_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <string>

#include "adapter/node/foreign_layouts.h"
#include "bot_core/images_t.hpp"
#include "bot_core/ins_t.hpp"
#include "core/bus/messages/convert.h"
#include "core/bus/transport/stock_lcm.h"
#include "core/files/dataset_error.h"
#include "microstrain/ins_t.hpp"
#include "sensor_msgs/CameraInfo.hpp"
#include "sensor_msgs/CompressedImage.hpp"
#include "sensor_msgs/Image.hpp"
#include "sensor_msgs/Imu.hpp"

namespace plslam::adapter {
namespace {

constexpr int64_t kNsPerS = 1'000'000'000;
constexpr int64_t kNsPerUs = 1'000;
/// In `bot_core.images_t.image_types`.
constexpr int kLeftImage = 0;
constexpr int kRightImage = 1;
/// In `sensor_msgs.PointField.datatype`.
constexpr uint8_t kFloat32 = 7;
/// Tolerance for quaternions that other programs have rounded; and no robot drives farther than the circumference of
/// the earth.
constexpr double kUnitTolerance = 1e-2;
constexpr double kFarthest_m = 4e7;

bool IsOfType(MessageBytes bytes, std::string_view type) {
  return bytes.size() >= 8 && bus::ReadInt64(bytes.data()) == ForeignLayout(type).fingerprint();
}

template <class Message>
Message Decoded(MessageBytes bytes, std::string_view type) {
  if (!IsOfType(bytes, type)) throw DatasetError(fmt::format("is not a {}", type));
  std::optional<Message> message = bus::CheckedMessage<Message>(ForeignLayout(type), bytes);
  if (!message) throw DatasetError(fmt::format("is a truncated or damaged {}", type));
  return *std::move(message);
}

int64_t FromStamp(const std_msgs::Header& header) {
  const std_msgs::Time& stamp = header.stamp;
  if (stamp.sec < 0 || stamp.nsec < 0 || stamp.nsec >= kNsPerS) {
    throw DatasetError(fmt::format("has an invalid stamp: {} s, {} ns", stamp.sec, stamp.nsec));
  }
  return stamp.sec * kNsPerS + stamp.nsec;
}

int64_t FromUtime(int64_t utime) {
  constexpr int64_t kLatest_us = int64_t{1} << 52;
  if (utime < 0 || utime > kLatest_us) throw DatasetError(fmt::format("has an invalid utime: {}", utime));
  return utime * kNsPerUs;
}

std_msgs::Header ToHeader(int64_t t_ns, std::string_view frame) {
  std_msgs::Header header{};
  header.stamp.sec = static_cast<int32_t>(t_ns / kNsPerS);
  header.stamp.nsec = static_cast<int32_t>(t_ns % kNsPerS);
  header.frame_id = frame;
  return header;
}

template <class Vector>
Vector ToVector(const Eigen::Vector3d& v) {
  Vector message{};
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
  return message;
}

geometry_msgs::Quaternion ToQuaternion(const Eigen::Quaterniond& q) {
  geometry_msgs::Quaternion message{};
  message.x = q.x();
  message.y = q.y();
  message.z = q.z();
  message.w = q.w();
  return message;
}

robot::ForeignImage FromBotImage(bot_core::image_t& image, int64_t utime) {
  robot::ForeignImage out;
  out.t_ns = FromUtime(utime);
  out.width_px = image.width;
  out.height_px = image.height;
  out.step_bytes = image.row_stride;
  out.encoding = robot::EncodingOfPixelFormat(image.pixelformat);
  out.bytes = std::move(image.data);
  return out;
}

geometry_msgs::TransformStamped ToTransform(int64_t t_ns, const RosTransform& transform) {
  geometry_msgs::TransformStamped message{};
  message.header = ToHeader(t_ns, transform.parent);
  message.child_frame_id = transform.child;
  message.transform.translation = ToVector<geometry_msgs::Vector3>(transform.T_parent_child.translation());
  message.transform.rotation = ToQuaternion(transform.T_parent_child.rotation());
  return message;
}

void Append(float value, std::vector<uint8_t>& bytes) {
  const auto bits = std::bit_cast<uint32_t>(value);
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<uint8_t>(bits >> (8 * i)));
}

}  // namespace

bool IsOfImages(MessageBytes bytes) {
  static constexpr std::string_view kTypes[] = {"bot_core.images_t", "sensor_msgs.Image",
                                                "sensor_msgs.CompressedImage"};
  return std::ranges::any_of(kTypes, [&](std::string_view type) { return IsOfType(bytes, type); });
}

std::pair<robot::ForeignImage, robot::ForeignImage> PairFromBytes(MessageBytes bytes) {
  auto message = Decoded<bot_core::images_t>(bytes, "bot_core.images_t");
  const auto image_of = [&](int type) {
    for (size_t i = 0; i < message.images.size(); ++i) {
      if (message.image_types[i] == type) return FromBotImage(message.images[i], message.utime);
    }
    throw DatasetError(fmt::format("has no {} image (type {})", type == kLeftImage ? "left" : "right", type));
  };
  robot::ForeignImage left = image_of(kLeftImage);
  return {std::move(left), image_of(kRightImage)};
}

robot::ForeignImage ImageFromBytes(MessageBytes bytes) {
  robot::ForeignImage out;
  if (IsOfType(bytes, "sensor_msgs.CompressedImage")) {
    auto message = Decoded<sensor_msgs::CompressedImage>(bytes, "sensor_msgs.CompressedImage");
    out.t_ns = FromStamp(message.header);
    out.format = std::move(message.format);
    out.bytes = std::move(message.data);
    return out;
  }
  if (!IsOfType(bytes, "sensor_msgs.Image")) {
    throw DatasetError("is neither a sensor_msgs.Image nor a sensor_msgs.CompressedImage");
  }
  auto message = Decoded<sensor_msgs::Image>(bytes, "sensor_msgs.Image");
  if (message.encoding.empty()) throw DatasetError("has no encoding");
  out.t_ns = FromStamp(message.header);
  out.width_px = message.width;
  out.height_px = message.height;
  out.step_bytes = message.step;
  out.encoding = message.encoding;
  out.is_big_endian = message.is_bigendian != 0;
  out.bytes = std::move(message.data);
  return out;
}

RosCameraInfo CameraInfoFromBytes(MessageBytes bytes) {
  const auto message = Decoded<sensor_msgs::CameraInfo>(bytes, "sensor_msgs.CameraInfo");
  using Rows3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  using Rows34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
  RosCameraInfo info;
  info.width_px = message.width;
  info.height_px = message.height;
  info.model = message.distortion_model;
  info.distortion = message.D;
  info.K = Eigen::Map<const Rows3>(&message.K[0]);
  info.R = Eigen::Map<const Rows3>(&message.R[0]);
  info.P = Eigen::Map<const Rows34>(&message.P[0]);
  info.binning_x = message.binning_x;
  info.binning_y = message.binning_y;
  info.roi = {message.roi.x_offset, message.roi.y_offset, message.roi.width, message.roi.height};
  return info;
}

RobotPose RobotPoseFromBytes(MessageBytes bytes) {
  const auto message = Decoded<nav_msgs::Odometry>(bytes, "nav_msgs.Odometry");
  const geometry_msgs::Point& p = message.pose.pose.position;
  const geometry_msgs::Quaternion& q = message.pose.pose.orientation;
  const Eigen::Quaterniond q_robot_b(q.w, q.x, q.y, q.z);
  const Eigen::Vector3d p_m(p.x, p.y, p.z);
  // Or the quaternion was never filled in; a NaN is not near 1, either.
  if (!(std::abs(q_robot_b.norm() - 1.0) < kUnitTolerance) || !(p_m.norm() < kFarthest_m)) {
    throw DatasetError("has an invalid pose");
  }
  return {FromStamp(message.header), SE3(q_robot_b, p_m)};
}

namespace {

constexpr std::string_view kRosImuType = "sensor_msgs.Imu";
constexpr std::string_view kBotInsType = "bot_core.ins_t";
constexpr std::string_view kMicrostrainType = "microstrain.ins_t";

ImuSample FromRosImu(const sensor_msgs::Imu& message) {
  constexpr double kNotMeasured = -1.0;
  const bool is_measured = message.angular_velocity_covariance[0] != kNotMeasured &&
                           message.linear_acceleration_covariance[0] != kNotMeasured;
  if (!is_measured) throw DatasetError("has a covariance that begins with -1, and so nothing was measured");
  const geometry_msgs::Vector3 &rate = message.angular_velocity, &force = message.linear_acceleration;
  return {FromStamp(message.header), {rate.x, rate.y, rate.z}, {force.x, force.y, force.z}};
}

template <class Message>
ImuSample FromIns(const Message& message) {
  return {FromUtime(message.utime),
          {message.gyro[0], message.gyro[1], message.gyro[2]},
          {message.accel[0], message.accel[1], message.accel[2]}};
}

ImuSample FromAnyImu(MessageBytes bytes) {
  if (IsOfType(bytes, kRosImuType)) return FromRosImu(Decoded<sensor_msgs::Imu>(bytes, kRosImuType));
  if (IsOfType(bytes, kBotInsType)) return FromIns(Decoded<bot_core::ins_t>(bytes, kBotInsType));
  if (IsOfType(bytes, kMicrostrainType)) return FromIns(Decoded<microstrain::ins_t>(bytes, kMicrostrainType));
  throw DatasetError(fmt::format("is none of {}, {} and {}", kRosImuType, kBotInsType, kMicrostrainType));
}

}  // namespace

ImuSample ImuSampleFromBytes(MessageBytes bytes) {
  ImuSample sample = FromAnyImu(bytes);
  if (!sample.rate_rad_s.allFinite() || !sample.force_m_s2.allFinite()) {
    throw DatasetError("has numbers that are not finite");
  }
  return sample;
}

bot_core::pose_t ToBotPose(const robot::BodyPose& pose) {
  bot_core::pose_t message{};
  message.utime = pose.t_ns / kNsPerUs;
  const Vector6d velocity = pose.velocity.value_or(Vector6d::Zero());
  const Eigen::Quaterniond& q = pose.T_map_b.rotation();
  const double q_wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  for (int i = 0; i < 4; ++i) message.orientation[i] = q_wxyz[i];
  for (int i = 0; i < 3; ++i) {
    message.pos[i] = pose.T_map_b.translation()[i];
    message.vel[i] = velocity[i];
    message.rotation_rate[i] = velocity[3 + i];
  }
  return message;
}

nav_msgs::Odometry ToOdometry(const RosOdometry& odometry) {
  nav_msgs::Odometry message{};
  message.header = ToHeader(odometry.t_ns, odometry.parent);
  message.child_frame_id = odometry.child;
  message.pose.pose.position = ToVector<geometry_msgs::Point>(odometry.T_parent_child.translation());
  message.pose.pose.orientation = ToQuaternion(odometry.T_parent_child.rotation());
  bus::ToArray(odometry.covariance, message.pose.covariance);
  message.twist.twist.linear = ToVector<geometry_msgs::Vector3>(odometry.velocity.head<3>());
  message.twist.twist.angular = ToVector<geometry_msgs::Vector3>(odometry.velocity.tail<3>());
  bus::ToArray(odometry.velocity_covariance, message.twist.covariance);
  return message;
}

tf2_msgs::TFMessage ToTransforms(int64_t t_ns, const std::vector<RosTransform>& transforms) {
  tf2_msgs::TFMessage message{};
  for (const RosTransform& transform : transforms) message.transforms.push_back(ToTransform(t_ns, transform));
  message.transforms_length = static_cast<int32_t>(message.transforms.size());
  return message;
}

sensor_msgs::PointCloud2 ToPointCloud(const SE3& T_b_c, const Map& map, int64_t t_ns) {
  sensor_msgs::PointCloud2 message{};
  message.header = ToHeader(t_ns, kRosMap);
  message.point_step = 12;
  for (const char* name : {"x", "y", "z"}) {
    sensor_msgs::PointField& field = message.fields.emplace_back();
    field.name = name;
    field.offset = 4 * message.fields_length++;
    field.datatype = kFloat32;
    field.count = 1;
  }
  for (const auto& [id, point] : map.points()) {
    const Eigen::Vector3d p_map = robot::ToMapFrame(T_b_c, point.p_w);
    for (const double value : p_map) Append(static_cast<float>(value), message.data);
    ++message.width;
  }
  message.height = 1;
  message.data_length = static_cast<int32_t>(message.data.size());
  message.row_step = message.data_length;
  message.is_dense = 1;
  return message;
}

}  // namespace plslam::adapter
