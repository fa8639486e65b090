// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "camera/pairing.h"

namespace plslam::camera {

/// Watches when images and frames have arrived, and decides whether the cameras have fallen silent.
class ImageWatch {
 public:
  using Clock = std::chrono::steady_clock;
  using Time = Clock::time_point;

  /// Images are missing after this time, and after so many periods. The first image of a pipeline takes longer.
  static constexpr std::chrono::milliseconds kSilence{2000};
  static constexpr std::chrono::milliseconds kFirstSilence{10000};
  static constexpr int64_t kSilentPeriods = 20;
  /// A stream that is not live, and may arrive over a network, has stalled after this time.
  static constexpr std::chrono::seconds kStall{10};

  /// The stream begins at `now`.
  explicit ImageWatch(Time now) : last_frame_(now) {}

  /// The stream begins again.
  void OnBegin(Time now) { last_frame_ = now; }
  /// A pipeline was built; the wait for its first image begins when it plays.
  void OnBuild() { gave_images_ = false; }
  void OnPlay(Time now) { played_ = now; }
  /// A frame is requested.
  void OnRequest(Time now) { waits_since_ = now; }
  void OnImage(Side side, Time now);
  /// A pair of images became a frame.
  void OnFrame(Time now) { last_frame_ = now; }

  /// Returns why no frames arrive from live cameras; empty: they do, or may yet.
  std::string Silence(Time now, std::chrono::nanoseconds period) const;
  bool HasStalled(Time now) const { return now - waits_since_ >= kStall; }
  Clock::duration SinceFrame(Time now) const { return now - last_frame_; }
  /// Whether each camera has sent an image since the start.
  bool HaveBothSent() const { return last_images_[0] && last_images_[1]; }

 private:
  bool SentSince(Side side, Time since) const;

  std::array<std::optional<Time>, 2> last_images_;  ///< by side
  Time last_frame_;
  Time played_;
  Time waits_since_;
  bool gave_images_ = false;  ///< since the pipeline was built
};

}  // namespace plslam::camera
