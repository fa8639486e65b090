// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace plslam::ros2 {

/// A publisher of a topic of ROS, as discovery describes it.
struct Publisher {
  std::string topic;  ///< "/odom"
  std::string type;   ///< "nav_msgs/msg/Odometry"
  bool is_reliable = false;
  bool is_latched = false;  ///< transient local
  bool is_ours = false;     ///< of another plslam_ros2
};

/// State of a reader.
struct ReaderState {
  int n_publishers = 0;          ///< matched ones
  std::string incompatible_qos;  ///< name of the policy by which others do not match; empty: none
  int64_t n_messages = 0;
};

/// A topic that is read, and what was received.
struct Input {
  std::string topic, type;
  ReaderState state;
  /// The last two stamps of images.
  std::optional<int64_t> stamp_ns, previous_stamp_ns;
};

/// Everything that explains why no frame arrives.
struct Symptoms {
  int domain = 0;
  Input left, right;
  /// CameraInfo; empty with a camera file.
  std::vector<Input> infos;
  std::vector<Publisher> publishers;
  bool has_rig = false;
  int64_t n_rejected = 0;  ///< messages since the last frame
  double max_skew_ms = 0.0;
};

/// Returns the reason why there are no frames, in one sentence: the first of these that is true. No publisher of any
/// topic (another domain, or network); no such topic, with the nearest names; another type; incompatible quality of
/// service; a publisher that sends nothing, or whose messages do not arrive; no CameraInfo; constant stamps; left and
/// right stamps of two clocks; images that cannot be used; unpaired stamps.
std::string WhyNoFrames(const Symptoms& symptoms);

/// Returns the topics of images.
std::set<std::string> ImageTopics(const std::vector<Publisher>& publishers);

bool IsImageType(const std::string& type);

}  // namespace plslam::ros2
