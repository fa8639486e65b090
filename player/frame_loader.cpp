// SPDX-License-Identifier: BSD-3-Clause
#include "player/frame_loader.h"

#include <sys/resource.h>
#include <unistd.h>

#include <span>
#include <utility>

namespace plslam::player {
namespace {

// Frames are loaded ahead, while other processes work on the previous one: reading has a lower priority than that work.
// (On Linux the priority is the thread's, and any user may lower it.)
void GiveWay() {
  constexpr int kNice = 10;
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

}  // namespace

FrameLoader::FrameLoader(const Dataset& dataset, PlayOrder order, size_t depth, const std::optional<int64_t>& sent_ns)
    : dataset_(dataset), order_(std::move(order)), depth_(depth), sent_ns_(sent_ns), worker_([this] { Work(); }) {}

FrameLoader::~FrameLoader() {
  Stop();
  worker_.join();
}

LoadedFrame FrameLoader::Load(const PlayOrder::Item& item) {
  LoadedFrame frame;
  try {
    frame.images = dataset_.Read(item.index);
    frame.T_w_l = dataset_.GroundTruth(item.index);
  } catch (const DatasetError& error) {
    frame.error = error.what();
  }
  frame.images.t_ns = item.t_ns;
  if (frame.error.empty()) AddImu(item, frame);
  return frame;
}

/// The samples since the last readable frame, at the times at which frames are played. Where frames do not follow each
/// other as in the dataset (backwards, or from its end to its beginning), the sensor did not measure the motion.
void FrameLoader::AddImu(const PlayOrder::Item& item, LoadedFrame& frame) {
  const std::vector<ImuSample>& all = dataset_.ImuSamples();
  const int64_t shift_ns = item.t_ns - dataset_.t_ns(item.index);
  const bool follows = sent_ns_ && (!shift_ns_ || *shift_ns_ == shift_ns);
  const int64_t from_ns = sent_ns_.value_or(item.t_ns);
  frame.imu_from_ns = from_ns;
  shift_ns_ = shift_ns;
  sent_ns_ = item.t_ns;
  if (all.empty() || !follows) return;
  // In the sensor's clock.
  const int64_t late_ns = shift_ns + dataset_.rig().imu->offset_ns();
  const std::span<const ImuSample> motion = SamplesOfMotion(all, from_ns - late_ns, item.t_ns - late_ns);
  frame.imu.assign(motion.begin(), motion.end());
  for (ImuSample& sample : frame.imu) sample.t_ns += shift_ns;
}

void FrameLoader::Work() {
  GiveWay();
  std::exception_ptr failure;
  try {
    for (auto item = order_.Next(); item; item = order_.Next()) {
      if (!Push(Load(*item))) break;
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
