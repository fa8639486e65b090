// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/datasets/calibrations/camera_info.h"
#include "core/datasets/recordings/ros_messages.h"
#include "core/robot/foreign_image.h"
#include "core/ros/ros_topics.h"
#include "ros2/diagnosis.h"
#include "ros2/domain.h"
#include "ros2/graph/node_info.h"

namespace plslam::ros2 {

/// A participant of a DDS domain that speaks as ROS 2 does, by Cyclone DDS; the one place that includes it. Readers
/// are best effort and volatile, which matches every publisher, and keep the last 5, but for /tf_static, wheels and
/// inertial sensors. All is of one thread but `Write`, and all throw std::runtime_error with the reason of DDS.
class Participant {
 public:
  /// `configuration` as `CycloneConfiguration` returns it.
  Participant(const Domain& domain, const std::string& configuration);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// Images of this topic: sensor_msgs/msg/Image, or CompressedImage if `is_compressed`. Both return the number of the
  /// reader. `take` may throw DatasetError, which `on_rejected` of `Receive` gets.
  size_t ReadImages(const std::string& topic, bool is_compressed, std::function<void(robot::ForeignImage)> take);
  size_t ReadInfos(const std::string& topic, std::function<void(RosCameraInfo, const std::string& frame)> take);
  /// tf2_msgs/msg/TFMessage of late publishers, too (reliable, transient local): /tf_static.
  void ReadStaticFrames(std::function<void(const std::string& parent, const std::string& child, const SE3&)> take);
  /// Asks for them again: publishers that discovered this reader before it knew them may not have sent the old ones (Fast
  /// DDS; it repeats them after three seconds, or not at all if the publisher's process reads them, too).
  void ReadStaticFramesAgain();

  /// Samples of an inertial sensor in sensor_msgs/msg/Imu.
  size_t ReadImu(const std::string& topic, std::function<void(const RosImu& message)> take);

  /// Poses of a robot's body in nav_msgs/msg/Odometry.
  size_t ReadOdometry(const std::string& topic, std::function<void(int64_t t_ns, const SE3& T_robot_b)> take);

  /// Waits for messages and handles them, for so long at most.
  void Receive(std::chrono::milliseconds limit,
               const std::function<void(const std::string& topic, const std::string& reason)>& on_rejected);
  ReaderState StateOf(size_t reader) const;

  /// Publishes a message of this row, in CDR, on `topic`; the writer is made with the first one. Safe from any thread.
  void Write(const RosTopic& row, const std::string& topic, const std::string& cdr);

  /// Returns the identities of its readers and writers of topics of ROS.
  std::vector<Guid> Readers() const;
  std::vector<Guid> Writers() const;

  /// Returns the bytes of an identity in the release of ROS of another node than that of the participant `own`: since
  /// Iron, endpoints name the hash of their type. Returns nullopt if there is no other node.
  std::optional<size_t> GidBytes(const Guid& own) const;

  /// Returns all publishers of topics of ROS in the domain but those of this participant.
  std::vector<Publisher> Publishers() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam::ros2
