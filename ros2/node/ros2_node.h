// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "core/process/process.h"
#include "core/robot/node/frame_source.h"
#include "core/robot/node/skipped_messages.h"
#include "core/ros/node/live_run.h"
#include "ros2/dds/participant.h"
#include "ros2/frame_inputs.h"
#include "ros2/held_infos.h"
#include "ros2/node/imu_reader.h"
#include "ros2/node/order_services.h"
#include "ros2/node/robot_odometry.h"
#include "ros2/options.h"
#include "ros2/pair_rates.h"

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
  void ReadImages(robot::Side side);
  void Listen();
  void Tick();
  void ReadStates(bool is_last = false);
  void TakeImage(robot::Side side, robot::ForeignImage image);
  void TakeInfo(robot::Side side, RosCameraInfo info, const std::string& frame);
  void UseInfos();
  void LogMounting(bool is_mounted);
  bool OthersPublishFrames() const;
  void Reject(const std::string& topic, const std::string& reason);
  void Write(const RosTopic& row, int64_t t_ns, const std::string& cdr);
  void ReportRate();
  void ReportLack();
  void AnnounceNode();

  bus::Process& process_;
  const Ros2Options options_;
  const Domain domain_;
  Participant participant_;
  robot::FrameSource frames_;
  FrameInputs inputs_;
  HeldInfos held_infos_;
  ImuReader imu_;
  RobotOdometry odometry_;
  PairRates rates_;
  bool is_mounted_ = false;  ///< the camera is on the body where /tf_static has it
  bool warned_of_loss_ = false;
  int n_lossy_reports_ = 0;  ///< in a row
  int64_t n_outages_ = 0;
  robot::SkippedMessages skipped_messages_;
  std::atomic<int64_t> first_t_ns_ = INT64_MAX;  ///< of the frames that were sent
  bus::LiveRun run_;
  OrderServices services_;
  std::atomic<bool> stopped_ = false;
  std::thread listener_;
};

bus::ProcessSpec Ros2Spec();

}  // namespace plslam::ros2
