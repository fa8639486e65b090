// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/lcm_robot.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "bot_core/images_t.hpp"
#include "core/bus/run_loop.h"
#include "core/geometry/body_frame.h"
#include "core/io/images/jpeg_codec.h"
#include "sensor_msgs/CameraInfo.hpp"
#include "sensor_msgs/CompressedImage.hpp"
#include "sensor_msgs/Image.hpp"
#include "sensor_msgs/Imu.hpp"

namespace plslam::test {
namespace {

using Clock = std::chrono::system_clock;

constexpr const char* kBotChannel = "CAMERA_PAIR";
constexpr const char* kSides[] = {"/left", "/right"};

std::vector<uint8_t> Jpeg(const cv::Mat& grey) {
  const std::string file = EncodeJpeg(grey, 95);
  return {file.begin(), file.end()};
}

bot_core::image_t BotImage(const cv::Mat& grey, bool jpeg) {
  bot_core::image_t image{};
  image.width = grey.cols;
  image.height = grey.rows;
  image.row_stride = grey.cols;
  image.pixelformat = jpeg ? 1196444237 : 1497715271;
  image.data = jpeg ? Jpeg(grey) : std::vector<uint8_t>(grey.datastart, grey.dataend);
  image.size = static_cast<int32_t>(image.data.size());
  return image;
}

std_msgs::Header Header(int64_t t_ns, const char* frame) {
  std_msgs::Header header{};
  header.stamp.sec = static_cast<int32_t>(t_ns / 1'000'000'000);
  header.stamp.nsec = static_cast<int32_t>(t_ns % 1'000'000'000);
  header.frame_id = frame;
  return header;
}

}  // namespace

LcmRobot::LcmRobot(const std::string& url, const Dataset& world, RobotImages images)
    : world_(world), images_(images), in_(url), out_(url) {
  // Rendered before, so that the processes have the cores for themselves.
  for (int i = 0; i < world.size(); ++i) frames_.push_back(world.Read(i));
  stamps_ns_.resize(frames_.size());
  Keep("POSE_BODY", poses_);
  Keep("/odom#nav_msgs[.]Odometry", odometry_);
  Keep("/tf#tf2_msgs[.]TFMessage", transforms_);
  Keep("/map#sensor_msgs[.]PointCloud2", maps_);
  listener_ = std::thread([this] {
    while (!stopped_) in_.handleTimeout(50);
  });
}

LcmRobot::~LcmRobot() {
  stopped_ = true;
  listener_.join();
}

template <class Message>
void LcmRobot::Keep(const std::string& channel, std::vector<Heard<Message>>& heard) {
  struct Place {
    std::mutex* mutex;
    std::vector<Heard<Message>>* heard;
  };
  const auto handler = [](const lcm::ReceiveBuffer*, const std::string&, const Message* message, Place place) {
    const std::scoped_lock lock(*place.mutex);
    place.heard->push_back({bus::NowS(), *message});
  };
  using Handler = void (*)(const lcm::ReceiveBuffer*, const std::string&, const Message*, Place);
  in_.subscribeFunction(channel, static_cast<Handler>(handler), Place{&mutex_, &heard})->setQueueCapacity(0);
}

std::vector<std::string> LcmRobot::AdapterArguments(const std::string& camera_file) const {
  if (images_ == RobotImages::kBotGrey || images_ == RobotImages::kBotJpeg) {
    return {"--images", kBotChannel, "--camera", camera_file};
  }
  const std::string type = images_ == RobotImages::kRosColour ? "#sensor_msgs.Image" : "#sensor_msgs.CompressedImage";
  return {"--left", kSides[0] + type, "--right", kSides[1] + type};
}

void LcmRobot::Drive(int begin, int end, double rate_hz) {
  auto due = std::chrono::steady_clock::now();
  for (int i = begin; i < end; ++i) {
    std::this_thread::sleep_until(due);
    // A busy machine makes the robot slow, not its frames dense.
    due = std::max(due + std::chrono::nanoseconds(std::llround(1e9 / rate_hz)), std::chrono::steady_clock::now());
    stamps_ns_[static_cast<size_t>(i)] =
        std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch()).count() * 1000;
    if (world_.rig().imu) PublishImu(i);
    PublishWheels(i);
    Publish(i);
  }
}

void LcmRobot::Cover(int begin, int end) {
  for (int i = begin; i < end; ++i) {
    StereoImages& images = frames_[static_cast<size_t>(i)];
    images.left = cv::Mat::zeros(images.left.size(), images.left.type());
    images.right = images.left;
  }
}

void LcmRobot::PublishImu(int frame) {
  const std::vector<ImuSample>& samples = world_.ImuSamples();
  if (frame == 0) {
    world_begin_ns_ = t_ns(0) - world_.t_ns(0);
    next_sample_ = 0;
  }
  stamps_ns_[static_cast<size_t>(frame)] = world_begin_ns_ + world_.t_ns(frame);
  for (bool is_after = false; next_sample_ < samples.size() && !is_after; ++next_sample_) {
    const ImuSample& sample = samples[next_sample_];
    is_after = sample.t_ns >= world_.t_ns(frame);
    sensor_msgs::Imu message{};
    message.header = Header(world_begin_ns_ + sample.t_ns, "imu");
    message.angular_velocity.x = sample.rate_rad_s.x();
    message.angular_velocity.y = sample.rate_rad_s.y();
    message.angular_velocity.z = sample.rate_rad_s.z();
    message.linear_acceleration.x = sample.force_m_s2.x();
    message.linear_acceleration.y = sample.force_m_s2.y();
    message.linear_acceleration.z = sample.force_m_s2.z();
    out_.publish(kImuChannel, &message);
  }
}

void LcmRobot::Publish(int frame) {
  const StereoImages& images = frames_[static_cast<size_t>(frame)];
  const int64_t t_ns = stamps_ns_[static_cast<size_t>(frame)];
  if (images_ == RobotImages::kBotGrey || images_ == RobotImages::kBotJpeg) {
    bot_core::images_t pair{};
    pair.utime = t_ns / 1000;
    pair.image_types = {0, 1};
    const bool jpeg = images_ == RobotImages::kBotJpeg;
    pair.images = {BotImage(images.left, jpeg), BotImage(images.right, jpeg)};
    pair.n_images = 2;
    out_.publish(kBotChannel, &pair);
    return;
  }
  if (frame % 10 == 0) PublishInfo();
  for (int side = 0; side < 2; ++side) {
    const cv::Mat& grey = side == 0 ? images.left : images.right;
    if (images_ == RobotImages::kRosCompressed) {
      sensor_msgs::CompressedImage message{};
      message.header = Header(t_ns, kSides[side]);
      message.format = "jpeg";
      message.data = Jpeg(grey);
      message.data_length = static_cast<int32_t>(message.data.size());
      out_.publish(std::string(kSides[side]) + "#sensor_msgs.CompressedImage", &message);
      continue;
    }
    cv::Mat rgb;
    cv::cvtColor(grey, rgb, cv::COLOR_GRAY2RGB);
    sensor_msgs::Image message{};
    message.header = Header(t_ns, kSides[side]);
    message.width = rgb.cols;
    message.height = rgb.rows;
    message.step = 3 * rgb.cols;
    message.encoding = "rgb8";
    message.data.assign(rgb.datastart, rgb.dataend);
    message.data_length = static_cast<int32_t>(message.data.size());
    out_.publish(std::string(kSides[side]) + "#sensor_msgs.Image", &message);
  }
}

void LcmRobot::PublishWheels(int frame) {
  const SE3 T_b_c = BodyFromCamera(world_.rig());
  const SE3 T_robot_b = T_b_c * world_.GroundTruth(0)->Inverse() * *world_.GroundTruth(frame) * T_b_c.Inverse();
  nav_msgs::Odometry message{};
  message.header = Header(t_ns(frame), "wheels");
  message.child_frame_id = "base_link";
  const Eigen::Vector3d& p = T_robot_b.translation();
  const Eigen::Quaterniond& q = T_robot_b.rotation();
  message.pose.pose.position.x = p.x();
  message.pose.pose.position.y = p.y();
  message.pose.pose.position.z = p.z();
  message.pose.pose.orientation.w = q.w();
  message.pose.pose.orientation.x = q.x();
  message.pose.pose.orientation.y = q.y();
  message.pose.pose.orientation.z = q.z();
  out_.publish(kWheelsChannel, &message);
}

void LcmRobot::PublishInfo() {
  const RigCalibration& rig = world_.rig();
  for (int side = 0; side < 2; ++side) {
    const CameraCalibration& camera = side == 0 ? rig.left : rig.right;
    sensor_msgs::CameraInfo info{};
    info.width = camera.width_px;
    info.height = camera.height_px;
    info.distortion_model = "plumb_bob";
    const double fx = camera.fx_px, fy = camera.fy_px, cx = camera.cx_px, cy = camera.cy_px;
    const double K[9] = {fx, 0, cx, 0, fy, cy, 0, 0, 1}, R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const double P[12] = {fx, 0, cx, side == 0 ? 0.0 : -fx * rig.baseline_m, 0, fy, cy, 0, 0, 0, 1, 0};
    std::memcpy(info.K, K, sizeof K);
    std::memcpy(info.R, R, sizeof R);
    std::memcpy(info.P, P, sizeof P);
    out_.publish(std::string(kSides[side]) + "/camera_info#sensor_msgs.CameraInfo", &info);
  }
}

}  // namespace plslam::test
