// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
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
#include "core/robot/stamp_pairing.h"

namespace plslam::robot {

/// Publishes the images of a robot as frames of a live stream, together with its rig, from a file or from CameraInfo:
/// pairs them, converts them to grey and numbers them.
///
/// Unpaired images are counted (`frames.unpaired`). An invalid image or rig throws DatasetError, with a phrase to follow
/// the name of its source ("has no ..."). Of one thread.
class FrameSource {
 public:
  struct Settings {
    std::string process;        ///< name of the process, and of its rig
    std::string camera_option;  ///< the option of a camera file: "adapter.camera"
    std::string camera;         ///< the camera file; empty: CameraInfo
    std::string left;           ///< name of the left images, or of the pairs
    std::string right;          ///< name of the right images; if it names depths, the camera is an RGB-D camera
    int64_t max_skew_ns = 0;    ///< largest difference between the stamps of a pair
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

  /// Publishes the end of the stream, if it has begun: readers then write their results.
  void End();
  /// Repeats the rig, as readers that start later need it; to be called once a second.
  void PublishRig();
  /// Whether the right images are depths, by their name.
  bool is_rgbd() const;
  bool has_rig() const { return rig_.has_value(); }
  /// Safe from any thread.
  int64_t n_sent() const { return n_sent_; }

 private:
  void UseWhiteLevel(int bright);
  void UseRig(RigCalibration rig);
  void Publish(StereoImages images);
  void PublishStream(const char* event, int64_t n_frames);

  bus::Process& process_;
  const Settings settings_;
  const Listener listener_;
  bus::FramePublisher publisher_;
  StampPairing<ForeignImage> pairing_;
  FrameNumbers numbers_;
  std::array<std::optional<RosCameraInfo>, 2> infos_;
  std::optional<SE3> T_b_l_;
  std::optional<RigCalibration> rig_;
  bool has_white_ = false;  ///< a 16-bit image was received
  int white_ = kWhiteOf16Bits;
  std::vector<uint8_t> rig_bytes_;
  std::atomic<int64_t> n_sent_ = 0;
  int64_t last_t_ns_ = -1;
};

}  // namespace plslam::robot
