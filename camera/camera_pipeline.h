// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "camera/pairing.h"
#include "camera/wakeup.h"

namespace plslam::camera {

/// A running pipeline of GStreamer with two appsinks, "left" and "right". Errors are std::runtime_error or returned,
/// in GStreamer's own words.
class CameraPipeline {
 public:
  /// Builds the pipeline and prepares it without playing: devices and files are opened, and the first images of a
  /// source that is not live are decoded. `wakeup`, which must outlive it, is called on each event.
  CameraPipeline(const std::string& text, Wakeup* wakeup);
  ~CameraPipeline();
  CameraPipeline(const CameraPipeline&) = delete;
  CameraPipeline& operator=(const CameraPipeline&) = delete;

  /// Live images arrive at their own time; a source that is not live waits for the next request.
  bool is_live() const { return is_live_; }
  void Play();
  /// Returns the next image of a camera, if there is one. Its time is that of capture on the clock of the pipeline
  /// (GStreamer's system clock, which is steady) if it is live, and otherwise counts from the beginning of the stream.
  std::optional<CapturedImage> Take(Side side);
  /// Returns the reason why images have stopped; empty if they have not.
  std::string Failure();
  /// The stream of a camera has ended, and its last image has been taken.
  bool ended(Side side) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  bool is_live_ = false;
};

/// Returns the current offset of UTC from the clock of live pipelines.
int64_t UtcOfGstClock_ns();

}  // namespace plslam::camera
