// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/bus/bus.h"
#include "core/geometry/calibration.h"
#include "core/ids/ids.h"
#include "core/io/images/image_file.h"

namespace plslam::bus {

/// Receives the camera in use, on the thread of `Bus::Run`.
///
/// Several publishers may repeat their cameras every second: one that sends frames, and idle ones. The camera in use is
/// that of the publisher of the frames (`Follow`), or the newest one while that publisher has sent none. `handler`
/// receives a rig only if it differs from the previous one. A camera with invalid values is rejected with one line in
/// the log, and `on_rejected` is called; the previous camera stays in use.
class CameraSubscriber {
 public:
  using Handler = std::function<void(const RigCalibration& rig)>;

  CameraSubscriber(Bus& bus, Handler handler, std::function<void()> on_rejected = nullptr);

  /// Sets the publisher of the frames, whose camera is used from here on: `handler` may be called. To be called with
  /// each frame, or the begin of a stream.
  void Follow(SourceId publisher);
  /// Whether frames should wait: their publisher has sent no camera, but may within two seconds after its first frame.
  bool awaits_rig() const;

  /// Returns the camera in use, for `Restore` in a process that replaces this one; empty before the first camera.
  const std::vector<uint8_t>& bytes() const;
  /// Hands on a camera of `publisher` that a previous process has stored. Throws std::runtime_error if the bytes are
  /// damaged.
  void Restore(const std::vector<uint8_t>& bytes, SourceId publisher);

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// Cuts stereo frames into strips and sends them. Images are 8-bit grey; the right one may be a 16-bit depth map.
/// Others are std::invalid_argument; one that readers would reject for its size (64 MB) is std::runtime_error, in one
/// sentence, before any strip of the frame is sent.
class FramePublisher {
 public:
  FramePublisher(Bus& bus, bool lockstep);
  void Publish(const StereoImages& images);

 private:
  void PublishImage(const StereoImages& frame, const cv::Mat& image, int8_t camera);

  Bus& bus_;
  bool lockstep_;
};

/// Reassembles strips of both the lockstep and the live channel, and delivers complete frames on the thread of
/// `Bus::Run`. In lockstep: every frame in order, repaired and acknowledged, and repeated if it was sent again; live:
/// the newest complete one, with the number of frames skipped before it.
class FrameSubscriber {
 public:
  struct Frame {
    StereoImages images;
    SourceId source;
    bool lockstep = false;
    int skipped = 0;      ///< frames of this publisher since the last one handled that were not
    double came_s = 0.0;  ///< when it was received completely; steady clock
  };
  enum class Mode {
    kReliable,  ///< for readers that need the newest frame in real time, and determine the publisher's pace
                ///< (vo_process)
    kPictures,  ///< in real time receives complete frames as available; `wanted` selects frame ids
  };

  /// Complete frames that may wait for the handler: lockstep publishers wait for it. In real time kPictures omits further
  /// frames, unless it is given another number.
  static constexpr int kMostWaiting = 3;

  /// `wanted` is called on the receiving thread: it must be quick, and safe there.
  FrameSubscriber(Bus& bus, Mode mode, std::function<void(const Frame&)> handler,
                  std::function<bool(FrameId frame_id)> wanted = nullptr, int most_in_real_time = kMostWaiting);
  ~FrameSubscriber();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace plslam::bus
