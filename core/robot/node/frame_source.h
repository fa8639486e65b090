// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/bus/messages/frame_channel.h"
#include "core/datasets/calibrations/camera_info.h"
#include "core/io/images/image_file.h"
#include "core/process/process.h"
#include "core/robot/foreign_image.h"
#include "core/robot/frame_numbers.h"
#include "core/robot/imu_queue.h"
#include "core/robot/stamp_pairing.h"

namespace plslam::robot {

/// Publishes the images of a robot as frames of a live stream, together with its rig, from a file or from CameraInfo:
/// pairs them, converts them to grey and numbers them.
///
/// Unpaired images are counted (`frames.unpaired`). An invalid image or rig throws DatasetError, with a phrase to follow
/// the name of its source ("has no ..."). Of one thread, but for the samples of an inertial sensor.
///
/// Samples are published in front of the frame that they lead to (lcmtypes/imu_t.lcm). A frame waits for the first
/// sample after it, for `kImuWait_s` at most and only while samples arrive, and is then published with those that have
/// arrived (`imu.incomplete` counts these frames, `imu.late` the samples that missed theirs).
class FrameSource {
 public:
  struct Settings {
    std::string process;        ///< name of the process, and of its rig
    std::string camera_option;  ///< the option of a camera file: "adapter.camera"
    std::string camera;         ///< the camera file; empty: CameraInfo
    std::string left;           ///< name of the left images, or of the pairs
    std::string right;          ///< name of the right images; if it names depths, the camera is an RGB-D camera
    int64_t max_skew_ns = 0;    ///< largest difference between the stamps of a pair
    std::string imu;            ///< name of the samples of the inertial sensor; empty: none
    std::string imu_option;     ///< its option: "adapter.imu"
    /// File of the sensor's calibration (core/datasets/imu_files.h); empty: `imu` of the camera file.
    std::string imu_calibration;
  };
  struct Listener {
    /// The rig in use, before the first frame and when it changes.
    std::function<void(const RigCalibration& rig)> on_rig;
    /// A frame with this stamp is about to be published.
    std::function<void(int64_t t_ns)> on_frame;
  };

  /// Throws where the file of the rig cannot be used.
  FrameSource(bus::Process& process, Settings settings, Listener listener);

  void AddImage(Side side, ForeignImage image);
  void AddPair(const ForeignImage& left, const ForeignImage& right);
  void AddInfo(Side side, RosCameraInfo info);
  /// Sets the pose of the left camera on the body for rigs of CameraInfo, which does not have it.
  void SetMounting(const SE3& T_b_l) { T_b_l_ = T_b_l; }

  /// Add samples of the inertial sensor; from any thread. Rates and forces that arrive apart are joined (`ImuJoin`).
  void AddImu(const ImuSample& sample);
  void AddRate(int64_t t_ns, const Eigen::Vector3d& rate_rad_s);
  void AddForce(int64_t t_ns, const Eigen::Vector3d& force_m_s2);
  /// Sets the pose of the inertial sensor in the left camera by the robot's transforms, before the first rig: a file
  /// that has its pose takes precedence.
  void SetImuMounting(const SE3& T_c_imu) { T_c_imu_ = T_c_imu; }

  /// Publishes frames whose samples have arrived, or whose wait is over; to be called after messages were added, and
  /// after `Wait`.
  void SendDue();
  /// Returns how long to wait for messages before the next call of `SendDue`, at most `limit`.
  std::chrono::milliseconds Wait(std::chrono::milliseconds limit) const;

  /// Publishes the end of the stream, if it has begun: readers then write their results.
  void End();
  /// Repeats the rig, as readers that start later need it; to be called once a second.
  void PublishRig();
  /// Whether the right images are depths, by their name.
  bool is_rgbd() const;
  bool has_rig() const { return rig_.has_value(); }
  /// Whether an inertial sensor needs `SetImuMounting`, since its file has no pose.
  bool needs_imu_mounting() const { return !settings_.imu.empty() && !imu_file_has_pose_; }
  /// Safe from any thread.
  int64_t n_sent() const { return n_sent_; }

  /// How long a frame waits for its samples: a period of a slow accelerometer, and its way here.
  static constexpr double kImuWait_s = 0.02;

 private:
  void UseWhiteLevel(int bright);
  void UseRig(RigCalibration rig);
  void Publish(StereoImages images);
  void ReadImuFile();
  void AddImuTo(RigCalibration& rig);
  void SendAll();
  bool AwaitsImu(int64_t t_ns) const;
  void PublishImu(int64_t t_ns);
  std::string ImuComplaint(int64_t t_ns) const;
  void PublishStream(const char* event, int64_t n_frames);

  bus::Process& process_;
  const Settings settings_;
  const Listener listener_;
  bus::FramePublisher publisher_;
  StampPairing<ForeignImage> pairing_;
  FrameNumbers numbers_;
  struct Waiting {
    StereoImages images;
    double until_s = 0.0;
  };
  std::deque<Waiting> waiting_;  ///< frames that wait for samples
  ImuQueue imu_;
  std::atomic<double> imu_at_s_ = -1e9;  ///< when the last sample arrived
  std::optional<SE3> T_c_imu_;
  bool imu_file_has_pose_ = false;
  std::optional<std::optional<ImuCalibration>> imu_calibration_;  ///< of the rigs; not set before the first one
  SE3 imu_T_b_l_;                                                 ///< the left camera of that
  int64_t n_incomplete_ = 0;                                      ///< frames without all of their samples
  int64_t n_in_a_row_ = 0;                                        ///< of these, since the last complete one
  bool warned_of_imu_ = false;
  std::array<std::optional<RosCameraInfo>, 2> infos_;
  std::optional<SE3> T_b_l_;
  std::optional<RigCalibration> rig_;
  bool has_white_ = false;  ///< a 16-bit image was received
  int white_ = kWhiteOf16Bits;
  std::vector<uint8_t> rig_bytes_;
  std::atomic<int64_t> n_sent_ = 0;
  int64_t last_t_ns_ = -1;  ///< of a pair
  std::optional<int64_t> sent_t_ns_;
};

}  // namespace plslam::robot
