// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "adapter/foreign_image.h"
#include "adapter/frame_numbers.h"
#include "adapter/node/complaints.h"
#include "adapter/node/foreign_messages.h"
#include "adapter/options.h"
#include "adapter/stamp_pairing.h"
#include "core/bus/messages/frame_channel.h"
#include "core/bus/transport/stock_lcm.h"
#include "core/process/process.h"

namespace plslam::adapter {

/// Foreign images to frames of the bus: pairs them, makes them grey, numbers and publishes them as a live stream, and
/// with them the rig, from a file or from the robot's own messages.
///
/// A foreign message that cannot be used is counted (`frames.rejected`, `frames.unpaired`) and passed over. All is
/// done on the thread that calls `StockLcm::Handle`, and `Tick` belongs there too.
class ImageSource {
 public:
  struct Listener {
    /// The rig in use, before the first frame and when it changes.
    std::function<void(const RigCalibration& rig)> on_rig;
    /// A frame with this stamp is about to be published.
    std::function<void(int64_t t_ns)> on_frame;
  };

  /// Throws where the file of the rig cannot be used.
  ImageSource(bus::Process& process, bus::StockLcm& foreign, const AdapterOptions& options, Listener listener);

  /// At 1 Hz: the rig once more, and what is missing.
  void Tick();

 private:
  using Pair = std::pair<ForeignImage, ForeignImage>;

  void Subscribe(bus::StockLcm& foreign);
  void Guarded(const std::string& channel, const std::function<void()>& take);
  void OnImage(Side side, MessageBytes bytes);
  void OnInfo(Side side, MessageBytes bytes);
  void OnPair(const Pair& pair);
  void UseRig(RigCalibration rig);
  void PublishRig();
  void Publish(StereoImages images);
  std::string WhatIsMissing() const;

  bus::Process& process_;
  const AdapterOptions options_;
  const std::string left_info_;
  const std::string right_info_;
  Listener listener_;
  bus::FramePublisher publisher_;
  StampPairing<ForeignImage> pairing_;
  FrameNumbers numbers_;
  Complaints complaints_;
  std::optional<RosCameraInfo> infos_[2];
  std::optional<RigCalibration> rig_;
  std::vector<uint8_t> rig_bytes_;
  int64_t n_messages_ = 0;
  int64_t n_sent_ = 0;
  int64_t n_rejected_ = 0;
  int64_t last_t_ns_ = -1;
};

/// The channel of the CameraInfo that goes with images: "/a/left/image_raw#sensor_msgs.Image" has
/// "/a/left/camera_info#sensor_msgs.CameraInfo", "/left" has "/left/camera_info".
std::string InfoChannelOf(const std::string& image_channel);

}  // namespace plslam::adapter
