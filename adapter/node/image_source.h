// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "adapter/foreign_image.h"
#include "adapter/frame_numbers.h"
#include "adapter/node/foreign_messages.h"
#include "adapter/node/inbox.h"
#include "adapter/node/skipped_messages.h"
#include "adapter/options.h"
#include "adapter/stamp_pairing.h"
#include "core/bus/messages/frame_channel.h"
#include "core/bus/transport/stock_lcm.h"
#include "core/io/images/image_file.h"
#include "core/process/process.h"

namespace plslam::adapter {

/// Converts foreign images to frames of the bus: pairs them, converts them to grey, numbers and publishes them as a
/// live stream, together with the rig, from a file or from the robot's own messages.
///
/// An invalid foreign message is counted (`frames.rejected`, `frames.unpaired`) and ignored, and so is one that has
/// waited too long because others arrived (`frames.dropped`). The thread of `StockLcm::Handle` only receives; `Work`
/// runs on a separate one.
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

  int64_t n_sent() const { return n_sent_; }

  /// Handles received messages until `Stop`, which any thread may call.
  void Work();
  void Stop() { inbox_.Stop(); }

 private:
  using Pair = std::pair<ForeignImage, ForeignImage>;
  struct Channel {
    std::string name;
    std::function<void(MessageBytes)> take;
  };

  void Subscribe(bus::StockLcm& foreign);
  void Handle(const Inbox::Message& message);
  void Tick();
  void OnImage(Side side, MessageBytes bytes);
  void OnInfo(Side side, MessageBytes bytes);
  void OnPair(const Pair& pair);
  void UseWhiteLevel(int bright);
  void UseRig(RigCalibration rig);
  void PublishRig();
  void Publish(StereoImages images);
  std::vector<std::string> SilentChannels() const;
  void ListImageChannels();
  std::string WhatIsMissing() const;

  bus::Process& process_;
  const AdapterOptions options_;
  const std::string left_info_;
  const std::string right_info_;
  Listener listener_;
  std::vector<Channel> channels_;
  Inbox inbox_;
  bus::FramePublisher publisher_;
  StampPairing<ForeignImage> pairing_;
  FrameNumbers numbers_;
  SkippedMessages skipped_messages_;
  std::array<std::optional<RosCameraInfo>, 2> infos_;
  std::optional<RigCalibration> rig_;
  bool has_white_ = false;  ///< a 16-bit image was received
  int white_ = kWhiteOf16Bits;
  std::vector<uint8_t> rig_bytes_;
  std::chrono::steady_clock::time_point list_at_;
  std::optional<std::string> image_channels_;  ///< what was found instead of the expected ones
  std::array<int64_t, 2> n_messages_{};        ///< by side; of pairs the first
  std::atomic<int64_t> n_sent_ = 0;
  int64_t n_rejected_ = 0;
  int64_t last_t_ns_ = -1;
};

/// Returns the CameraInfo channel of an image channel: "/a/left/image_raw#sensor_msgs.Image" has
/// "/a/left/camera_info#sensor_msgs.CameraInfo", "/left" has "/left/camera_info".
std::string InfoChannelOf(const std::string& image_channel);

}  // namespace plslam::adapter
