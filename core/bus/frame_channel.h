#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "core/bus/bus.h"
#include "core/io/stereo_images.h"

namespace plslam::bus {

/// Cuts stereo frames into strips and sends them.
class FramePublisher {
 public:
  FramePublisher(Bus& bus, bool lockstep);
  void Publish(const StereoImages& images);

 private:
  Bus& bus_;
  bool lockstep_;
};

/// Puts strips together again, of both the lockstep and the live channel, and delivers whole frames on the thread of
/// `Bus::Run`. In lockstep every frame in order; live the newest whole one, with the number passed over before it.
class FrameSubscriber {
 public:
  struct Frame {
    StereoImages images;
    int64_t source = 0;
    bool lockstep = false;
    int skipped = 0;
  };
  enum class Mode {
    kReliable,    ///< repairs and acknowledges (vo_process)
    kBestEffort,  ///< takes whole frames when it gets them (pictures); `wanted` says which frame ids are worth it
  };

  FrameSubscriber(Bus& bus, Mode mode, std::function<void(const Frame&)> handler,
                  std::function<bool(int64_t frame_id)> wanted = nullptr);
  ~FrameSubscriber();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam::bus
