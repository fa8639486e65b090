// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"
#include "core/process/process.h"
#include "core/robot/imu_queue.h"

namespace plslam::robot {

/// The inertial sensor of a robot: its calibration in the rig, and its samples, which are published in front of the frame
/// that they lead to (lcmtypes/imu_t.lcm).
///
/// Samples that arrive after their frame was sent are counted (`imu.late`), and so are frames that were sent without all
/// of theirs (`imu.incomplete`). The warning `imu_missing` reports a silent sensor and one of another clock,
/// `imu_uncalibrated` one without a pose. Of one thread, but for the functions that add samples.
class ImuInput {
 public:
  struct Settings {
    std::string name;    ///< of its samples: a topic or channel; empty: there is no sensor
    std::string option;  ///< of that name: "adapter.imu"
    /// File of its calibration (core/datasets/imu_files.h), the value of `option` + "_calibration"; empty: `imu` of the
    /// camera file.
    std::string calibration;
    std::string camera;  ///< the camera file; empty: none
  };

  /// Throws DatasetError where the file cannot be used.
  ImuInput(bus::Process& process, Settings settings);

  /// Add samples; from any thread. Rates and forces that arrive apart are joined (`ImuJoin`).
  void Add(const ImuSample& sample);
  void AddRate(int64_t t_ns, const Eigen::Vector3d& rate_rad_s);
  void AddForce(int64_t t_ns, const Eigen::Vector3d& force_m_s2);

  /// Whether there is a sensor without a pose in its file, so that `SetMounting` is needed.
  bool needs_mounting() const { return !settings_.name.empty() && !file_has_pose_; }
  /// Sets the pose of the sensor in the left camera by the robot's transforms. A pose in the file takes precedence.
  /// After the first rig it takes effect when the left camera moves on the body.
  void SetMounting(const SE3& T_c_imu) { T_c_imu_ = T_c_imu; }
  /// Sets the sensor of a rig. That of the first rig is that of later ones, as long as the left camera does not move.
  void AddTo(RigCalibration& rig);

  /// Whether the frame at this time has to wait for samples. A sensor that is silent delays no frame.
  bool Awaits(const RigCalibration& rig, int64_t t_ns) const;
  /// Publishes the samples between the previous frame and the one at this time, if the rig has the sensor. After samples
  /// that came too late for their frames, the motion begins at the last frame with all samples up to it, at most a second
  /// before.
  void Publish(const RigCalibration& rig, int64_t t_ns);

 private:
  void ReadFile();
  void Report(int64_t t_ns, bool is_complete);
  std::string WarningText(int64_t t_ns) const;

  bus::Process& process_;
  const Settings settings_;
  ImuQueue queue_;
  std::atomic<double> added_s_ = -1e9;  ///< when the last sample arrived
  bool file_has_pose_ = false;
  std::optional<SE3> T_c_imu_;
  std::optional<std::optional<ImuCalibration>> calibration_;  ///< of the rigs; not set before the first one
  SE3 T_b_l_;                                                 ///< pose of the left camera to which it refers
  std::optional<int64_t> sent_t_ns_;                          ///< time of the previous frame
  /// Times of sent frames: the last one with all samples up to it, and those since then.
  std::deque<int64_t> open_t_ns_;
  int64_t n_incomplete_ = 0;  ///< frames without all of their samples
  int64_t n_in_a_row_ = 0;    ///< of these, since the last complete one
  bool has_warned_ = false;
};

}  // namespace plslam::robot
