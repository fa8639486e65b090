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
  /// Builds it, and gets it as far as it goes without playing: devices and files are opened, and of what is not live
  /// the first images are decoded. `wakeup`, which must live longer, is called when there is something new.
  CameraPipeline(const std::string& text, Wakeup* wakeup);
  ~CameraPipeline();
  CameraPipeline(const CameraPipeline&) = delete;
  CameraPipeline& operator=(const CameraPipeline&) = delete;

  /// Images come when they are taken; what is not live waits until it is asked for the next one.
  bool is_live() const { return is_live_; }
  void Play();
  /// The next image of a camera, where there is one. Its time is that of capture on the clock of the pipeline
  /// (GStreamer's system clock, which is steady) where it is live, and otherwise counts from the begin of the stream.
  std::optional<CapturedImage> Take(Side side);
  /// Why no more images come; empty where all is well.
  std::string Failure();
  /// The stream of a camera has ended, and its last image has been taken.
  bool ended(Side side) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  bool is_live_ = false;
};

/// Difference of UTC from the clock of live pipelines, now.
int64_t UtcOfGstClock_ns();

}  // namespace plslam::camera
