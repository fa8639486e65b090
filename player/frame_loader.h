// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/datasets/dataset.h"
#include "core/stream/frame_source.h"
#include "player/pacing.h"

namespace plslam::player {

using stream::LoadedFrame;

/// Reads and decodes frames ahead, on a separate thread, so that this overlaps with the work of the readers. The order
/// is always that of `order`.
class FrameLoader {
 public:
  /// Keeps at most `depth` frames ready. `sent_ns` is the time of the last frame that was sent before.
  FrameLoader(const Dataset& dataset, PlayOrder order, size_t depth, const std::optional<int64_t>& sent_ns = {});
  ~FrameLoader();
  FrameLoader(const FrameLoader&) = delete;
  FrameLoader& operator=(const FrameLoader&) = delete;

  /// Waits for the next frame; nullopt after the last one and after `Stop`. Errors other than DatasetError leave
  /// here.
  std::optional<LoadedFrame> Next();

  /// Ends `Next`, from any thread.
  void Stop();

 private:
  void Work();
  LoadedFrame Load(const PlayOrder::Item& item);
  void AddImu(const PlayOrder::Item& item, LoadedFrame& frame);
  bool Push(LoadedFrame frame);

  const Dataset& dataset_;
  PlayOrder order_;
  const size_t depth_;
  /// Time of the last readable frame, and the time since which all frames have followed each other as in the dataset;
  /// of the worker.
  std::optional<int64_t> sent_ns_;
  std::optional<int64_t> shift_ns_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<LoadedFrame> ready_;
  std::exception_ptr failure_;
  bool finished_ = false;
  bool stopped_ = false;
  std::thread worker_;
};

}  // namespace plslam::player
