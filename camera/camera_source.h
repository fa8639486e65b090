// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "camera/camera_pipeline.h"
#include "camera/capture_health.h"
#include "camera/frame_order.h"
#include "camera/image_watch.h"
#include "camera/pairing.h"
#include "camera/rig_file.h"
#include "camera/wakeup.h"
#include "core/stream/frame_source.h"

namespace plslam::camera {

/// Frames of two live cameras, or of two video files, through GStreamer.
///
/// Times of live frames are UTC: the capture time from the driver, on a steady clock, plus the offset of UTC from that
/// clock at the start. Times of files count from their beginning. A pipeline of live cameras that fails, ends or falls
/// silent is rebuilt, with growing pauses, until frames come; `give_up_s` after the last frame it is given up, and
/// `Next` throws. At the start a failure is thrown at once, unless the process resumes after the frames of one that was
/// killed.
class CameraSource : public stream::FrameSource {
 public:
  struct Listener {
    /// Called after each frame: numbers for the status.
    std::function<void(const CaptureHealth& health, const Pairing& pairing)> on_frame;
    /// Called with the reason when frames stop; with an empty one when they come again.
    std::function<void(const std::string& why)> on_outage;
  };

  /// Throws std::runtime_error if the pipeline cannot be built.
  CameraSource(LiveRig live, bool resumes, Listener listener);

  std::string name() const override { return live_.path; }
  const RigCalibration& rig() const override { return live_.rig; }
  int64_t size() const override { return -1; }
  int64_t period_ns() const override;
  bool is_live() const override { return is_live_; }
  int64_t Begin(const std::optional<stream::ResumePoint>& behind) override;
  std::optional<stream::LoadedFrame> Next() override;
  void Stop() override;

 private:
  using Clock = ImageWatch::Clock;

  Pairing MakePairing() const;
  void Build();
  void Play();
  void TakeImages();
  void ReportStall();
  bool Take(Side side);
  bool IsOver();
  std::optional<stream::LoadedFrame> End() const;
  void OnFailure(const std::string& why);
  void BuildAgain();
  void CheckSize(Side side, const cv::Mat& pixels) const;
  std::string Named(const std::string& what) const;
  stream::LoadedFrame MakeFrame(CapturedPair pair);

  const LiveRig live_;
  const Listener listener_;
  const std::string text_;
  const int64_t utc_ns_;
  const bool resumes_;
  bool is_live_ = false;
  Wakeup wakeup_;
  std::atomic<bool> stopped_ = false;
  std::unique_ptr<CameraPipeline> pipeline_;
  bool playing_ = false;
  Pairing pairing_;
  CaptureHealth health_;
  ImageWatch watch_{Clock::now()};
  FrameOrder order_;
  std::chrono::milliseconds pause_;
  std::string outage_;  // reason why no frames arrive; empty: they do
};

}  // namespace plslam::camera
