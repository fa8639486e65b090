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
#include "core/robot/node/imu_input.h"
#include "core/robot/stamp_pairing.h"

namespace plslam::robot {

/// Publishes the images of a robot as frames of a live stream, together with its rig, from a file or from CameraInfo:
/// pairs them, converts them to grey and numbers them.
///
/// Unpaired images are counted (`frames.unpaired`). An invalid image or rig throws DatasetError, with a phrase to follow
/// the name of its source ("has no ..."). Of one thread, but for the samples of an inertial sensor.
///
/// A frame waits for the first sample of the inertial sensor after it, for `kImuWait_s` at most and only while samples
/// arrive, and is then published with those that have arrived.
class FrameSource {
 public:
  struct Settings {
    std::string process;        ///< name of the process, and of its rig
    std::string camera_option;  ///< the option of a camera file: "adapter.camera"
    std::string camera;         ///< the camera file; empty: CameraInfo
    std::string left;           ///< name of the left images, or of the pairs
    std::string right;          ///< name of the right images; if it names depths, the camera is an RGB-D camera
    int64_t max_skew_ns = 0;    ///< largest difference between the stamps of a pair
    ImuInput::Settings imu;
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

  /// The inertial sensor, whose samples may be added on any thread.
  ImuInput& imu() { return imu_; }
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
  /// Safe from any thread.
  int64_t n_sent() const { return n_sent_; }

  /// How long a frame waits for its samples: a period of a slow accelerometer, and its way here.
  static constexpr double kImuWait_s = 0.02;

 private:
  void UseWhiteLevel(int bright);
  void UseRig(RigCalibration rig);
  void Publish(StereoImages images);
  void SendAll();
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
  ImuInput imu_;
  std::deque<Waiting> waiting_;  ///< frames that wait for samples
  std::array<std::optional<RosCameraInfo>, 2> infos_;
  std::optional<SE3> T_b_l_;
  std::optional<RigCalibration> rig_;
  bool has_white_ = false;  ///< a 16-bit image was received
  int white_ = kWhiteOf16Bits;
  std::vector<uint8_t> rig_bytes_;
  std::atomic<int64_t> n_sent_ = 0;
  int64_t last_t_ns_ = -1;  ///< of a pair
};

}  // namespace plslam::robot
