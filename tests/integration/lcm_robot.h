// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "bot_core/pose_t.hpp"
#include "core/datasets/dataset.h"
#include "nav_msgs/Odometry.hpp"
#include "sensor_msgs/PointCloud2.hpp"
#include "tf2_msgs/TFMessage.hpp"

namespace plslam::test {

/// Message types of a robot's camera driver.
enum class RobotImages { kBotGrey, kBotJpeg, kRosColour, kRosCompressed };

/// The channel of the inertial sensor, of worlds that have one.
inline constexpr const char* kImuChannel = "/imu#sensor_msgs.Imu";

/// The channel of the robot's own odometry.
inline constexpr const char* kWheelsChannel = "/wheels#nav_msgs.Odometry";

/// A robot that uses only the types of LCM robots and no others of this project: it publishes a world's images in real
/// time, as a camera driver does, and the pose of its wheel odometry, and stores the messages that it receives.
class LcmRobot {
 public:
  /// A received message, and its time of arrival by the steady clock in s.
  template <class Message>
  struct Heard {
    double at_s = 0.0;
    Message message;
  };

  LcmRobot(const std::string& url, const Dataset& world, RobotImages images);
  ~LcmRobot();
  LcmRobot(const LcmRobot&) = delete;
  LcmRobot& operator=(const LcmRobot&) = delete;

  /// Returns the options of the adapter for these images.
  std::vector<std::string> AdapterArguments(const std::string& camera_file) const;

  /// Publishes frames [begin, end) at `rate_hz`, stamped with times of day that continue from call to call. In a world
  /// with an inertial sensor stamps are those of the world, since frame 0 was published, and the samples that lead to
  /// a frame are published before it.
  void Drive(int begin, int end, double rate_hz);
  /// Makes the images of frames [begin, end) black.
  void Cover(int begin, int end);
  /// The stamp of a published frame.
  int64_t t_ns(int frame) const { return stamps_ns_.at(static_cast<size_t>(frame)); }

  std::vector<Heard<bot_core::pose_t>> poses() const { return Copy(poses_); }
  std::vector<Heard<nav_msgs::Odometry>> odometry() const { return Copy(odometry_); }
  std::vector<Heard<tf2_msgs::TFMessage>> transforms() const { return Copy(transforms_); }
  std::vector<Heard<sensor_msgs::PointCloud2>> maps() const { return Copy(maps_); }

 private:
  template <class Message>
  std::vector<Heard<Message>> Copy(const std::vector<Heard<Message>>& heard) const {
    const std::scoped_lock lock(mutex_);
    return heard;
  }
  template <class Message>
  void Keep(const std::string& channel, std::vector<Heard<Message>>& heard);
  void Publish(int frame);
  void PublishInfo();
  void PublishWheels(int frame);
  void PublishImu(int frame);

  const Dataset& world_;
  const RobotImages images_;
  std::vector<StereoImages> frames_;
  std::vector<int64_t> stamps_ns_;
  int64_t world_begin_ns_ = 0;  ///< time of day of the world's begin
  size_t next_sample_ = 0;
  lcm::LCM in_;
  lcm::LCM out_;
  mutable std::mutex mutex_;
  std::vector<Heard<bot_core::pose_t>> poses_;
  std::vector<Heard<nav_msgs::Odometry>> odometry_;
  std::vector<Heard<tf2_msgs::TFMessage>> transforms_;
  std::vector<Heard<sensor_msgs::PointCloud2>> maps_;
  std::atomic<bool> stopped_ = false;
  std::thread listener_;
};

}  // namespace plslam::test
