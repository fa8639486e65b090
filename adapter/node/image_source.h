// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "adapter/node/foreign_messages.h"
#include "adapter/options.h"
#include "core/bus/transport/stock_lcm.h"
#include "core/process/process.h"
#include "core/robot/frame_progress.h"
#include "core/robot/node/frame_source.h"
#include "core/robot/node/inbox.h"
#include "core/robot/node/skipped_messages.h"

namespace plslam::adapter {

/// Converts foreign images to frames of the bus: pairs them, converts them to grey, numbers and publishes them as a
/// live stream, together with the rig, from a file or from the robot's own messages.
///
/// An invalid foreign message is counted (`frames.rejected`, `frames.unpaired`) and ignored, and so is one that has
/// waited too long because others arrived (`frames.dropped`). Four seconds without frames, after there were some, are
/// an outage: counted (`frames.outages`), and reported by the warning `adapter_no_frames`. The thread of
/// `StockLcm::Handle` only receives, and adds samples of an inertial sensor (`imu.rejected`: invalid ones); `Work` runs
/// on a separate one.
class ImageSource {
 public:
  /// Throws where the file of the rig cannot be used.
  ImageSource(bus::Process& process, bus::StockLcm& foreign, const AdapterOptions& options,
              robot::FrameSource::Listener listener);

  int64_t n_sent() const { return frames_.n_sent(); }

  /// Handles received messages until `Stop`, which any thread may call.
  void Work();
  void Stop() { inbox_.Stop(); }

 private:
  struct Channel {
    std::string name;
    std::function<void(MessageBytes)> take;
  };

  void Subscribe(bus::StockLcm& foreign);
  void Handle(const robot::Inbox::Message& message);
  void Tick();
  void OnImage(robot::Side side, MessageBytes bytes);
  void OnImu(MessageBytes bytes);
  std::vector<std::string> SilentChannels() const;
  void ListImageChannels();
  std::string WhatIsMissing() const;
  void ReportLack();

  bus::Process& process_;
  const AdapterOptions options_;
  const std::string left_info_;
  const std::string right_info_;
  std::vector<Channel> channels_;
  robot::Inbox inbox_;
  robot::FrameSource frames_;
  robot::SkippedMessages skipped_messages_;
  // Used by the thread of `StockLcm::Handle`.
  robot::SkippedMessages skipped_samples_;
  int64_t n_imu_rejected_ = 0;
  std::chrono::steady_clock::time_point list_at_;
  std::optional<std::string> image_channels_;  ///< what was found instead of the expected ones
  /// Images by side, of pairs the first, and rejected messages.
  struct Received {
    std::array<int64_t, 2> n_messages{};
    int64_t n_rejected = 0;
  };
  Received received_;
  Received received_before_;  ///< at the last progress
  robot::FrameProgress progress_;
  bool is_out_ = false;  ///< no frames, after there were some
  int64_t n_outages_ = 0;
};

/// Returns the CameraInfo channel of an image channel (`robot::InfoTopicOf`): "/a/left/image_raw#sensor_msgs.Image" has
/// "/a/left/camera_info#sensor_msgs.CameraInfo", "/left" has "/left/camera_info".
std::string InfoChannelOf(const std::string& image_channel);

}  // namespace plslam::adapter
