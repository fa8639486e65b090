// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/datasets/recordings/ros_messages.h"
#include "core/geometry/static_frames.h"
#include "core/process/process.h"
#include "core/robot/node/frame_source.h"
#include "core/robot/node/skipped_messages.h"
#include "core/ros/node/live_run.h"
#include "ros2/dds/participant.h"
#include "ros2/image_rate.h"
#include "ros2/node/order_services.h"
#include "ros2/options.h"

namespace plslam::ros2 {

/// Connects a robot that speaks ROS 2 to the bus: its images in, poses and the map out, through DDS. It can be killed and
/// restarted in the middle of a session: `waiting for images` (no frame yet; `WhyNoFrames` is its reason) and `running`
/// are its states.
class Ros2Node {
 public:
  Ros2Node(bus::Process& process, const Ros2Options& options);
  ~Ros2Node();
  Ros2Node(const Ros2Node&) = delete;
  Ros2Node& operator=(const Ros2Node&) = delete;

 private:
  struct Side {
    Input input;
    size_t reader = 0;
    int64_t n_before = 0;  ///< messages at the last progress
  };

  void Listen();
  void Tick();
  void ReadStates();
  void TakeImage(robot::Side side, robot::ForeignImage image);
  void TakeInfo(robot::Side side, RosCameraInfo info, const std::string& frame);
  void UseInfos();
  void Reject(const std::string& topic, const std::string& reason);
  void Write(const RosTopic& row, int64_t t_ns, const std::string& cdr);
  void ReportRate();
  void ReportLack();
  void NoteProgress();
  void ReadImu();
  void TakeImu(const RosImu& message, bool has_rate, bool has_force);
  bool AwaitsFrames(bool knows_mounting) const;
  void TakeMotion(int64_t t_ns, const SE3& T_robot_b);
  void ReportMotions();
  void AnnounceNode();

  bus::Process& process_;
  const Ros2Options options_;
  const Domain domain_;
  Participant participant_;
  std::array<Side, 2> sides_;
  std::vector<Side> infos_;
  StaticFrames static_frames_;
  std::string left_frame_;  ///< of the left images
  std::array<std::optional<RosCameraInfo>, 2> held_infos_;
  double held_since_s_ = 0.0;
  bool awaits_frames_ = false;  ///< /tf_static
  robot::FrameSource frames_;
  robot::SkippedMessages skipped_messages_;
  int64_t n_rejected_ = 0, n_rejected_before_ = 0;  ///< and those before the last frame
  std::array<ImageRate, 2> rates_;                  ///< by side
  int64_t pair_bytes_ = 0;                          ///< largest so far
  bool warned_of_loss_ = false;
  std::string imu_frame_;  ///< of the inertial sensor; empty before its first message
  std::set<std::string> imu_topics_;
  int64_t n_imu_rejected_ = 0;
  std::optional<size_t> motions_;  ///< reader of the robot's odometry
  int64_t n_motions_ = 0, n_motions_rejected_ = 0;
  bool warned_of_motions_ = false;
  std::string lack_;                             ///< the last reason for no frames
  int64_t n_sent_ = 0;                           ///< frames at the last progress
  double progress_s_ = 0.0;                      ///< when that was
  std::atomic<int64_t> first_t_ns_ = INT64_MAX;  ///< of the frames that were sent
  bus::LiveRun run_;
  OrderServices services_;
  std::atomic<bool> stopped_ = false;
  std::thread listener_;
};

bus::ProcessSpec Ros2Spec();

}  // namespace plslam::ros2
