// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "core/bus/messages/frame_channel.h"
#include "core/bus/run_loop.h"
#include "core/datasets/dataset.h"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::test {

/// The complete frames on a bus, as vo_process reads them.
class BusFrames {
 public:
  explicit BusFrames(const std::string& url, bool keeps_images = false)
      : bus_(OptionsOf(url)),
        frames_(*bus_, bus::FrameSubscriber::Mode::kReliable,
                [this, keeps_images](const bus::FrameSubscriber::Frame& frame) {
                  const std::scoped_lock lock(mutex_);
                  at_s_.emplace(frame.images.t_ns, bus::NowS());
                  if (!keeps_images) return;
                  StereoImages& kept = images_[frame.images.t_ns];
                  kept = frame.images;
                  kept.left = frame.images.left.clone();
                  kept.right = frame.images.right.clone();
                }) {
    bus_.Start();
  }
  ~BusFrames() { bus_.Join(); }
  BusFrames(const BusFrames&) = delete;
  BusFrames& operator=(const BusFrames&) = delete;

  /// Arrival times by the stamps of the frames.
  std::map<int64_t, double> at_s() const {
    const std::scoped_lock lock(mutex_);
    return at_s_;
  }
  std::map<int64_t, StereoImages> images() const {
    const std::scoped_lock lock(mutex_);
    return images_;
  }

  static bus::BusOptions OptionsOf(const std::string& url) {
    bus::BusOptions options;
    options.url = url;
    return options;
  }

 private:
  mutable std::mutex mutex_;
  std::map<int64_t, double> at_s_;
  std::map<int64_t, StereoImages> images_;
  bus::test::RunningBus bus_;
  bus::FrameSubscriber frames_;
};

}  // namespace plslam::test
