// SPDX-License-Identifier: BSD-3-Clause
#include "player/frame_loader.h"

#include <sys/resource.h>
#include <unistd.h>

#include <utility>

namespace plslam::player {
namespace {

LoadedFrame Load(const Dataset& dataset, const PlayOrder::Item& item) {
  LoadedFrame frame;
  try {
    frame.images = dataset.Read(item.index);
    frame.T_w_l = dataset.GroundTruth(item.index);
  } catch (const DatasetError& error) {
    frame.error = error.what();
  }
  frame.images.t_ns = item.t_ns;
  return frame;
}

// Frames are loaded ahead, while other processes work on the previous one: reading has a lower priority than that work.
// (On Linux the priority is the thread's, and any user may lower it.)
void GiveWay() {
  constexpr int kNice = 10;
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

}  // namespace

FrameLoader::FrameLoader(const Dataset& dataset, PlayOrder order, size_t depth)
    : dataset_(dataset), order_(std::move(order)), depth_(depth), worker_([this] { Work(); }) {}

FrameLoader::~FrameLoader() {
  Stop();
  worker_.join();
}

void FrameLoader::Work() {
  GiveWay();
  std::exception_ptr failure;
  try {
    for (auto item = order_.Next(); item; item = order_.Next()) {
      if (!Push(Load(dataset_, *item))) break;
    }
  } catch (...) {
    failure = std::current_exception();
  }
  const std::scoped_lock lock(mutex_);
  failure_ = failure;
  finished_ = true;
  changed_.notify_all();
}

bool FrameLoader::Push(LoadedFrame frame) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return stopped_ || ready_.size() < depth_; });
  if (stopped_) return false;
  ready_.push_back(std::move(frame));
  changed_.notify_all();
  return true;
}

std::optional<LoadedFrame> FrameLoader::Next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return stopped_ || finished_ || !ready_.empty(); });
  if (stopped_) return std::nullopt;
  if (ready_.empty()) {
    if (failure_) std::rethrow_exception(failure_);
    return std::nullopt;
  }
  LoadedFrame frame = std::move(ready_.front());
  ready_.pop_front();
  changed_.notify_all();
  return frame;
}

void FrameLoader::Stop() {
  const std::scoped_lock lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

}  // namespace plslam::player
