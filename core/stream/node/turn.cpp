// SPDX-License-Identifier: BSD-3-Clause
#include "core/stream/node/turn.h"

#include <utility>

namespace plslam::stream {

void Turn::Expect(const ResumePoint& frame) {
  const std::scoped_lock lock(mutex_);
  expected_ = frame;
  has_pose_ = resumed_ && newest_ && newest_->frame_id >= frame.frame_id && newest_->t_ns >= frame.t_ns;
  new_reader_ = false;
}

void Turn::OnPose(const ResumePoint& frame) {
  const std::scoped_lock lock(mutex_);
  if (!newest_ || newest_->frame_id < frame.frame_id) newest_ = frame;
  if (!expected_ || expected_->frame_id != frame.frame_id) return;
  has_pose_ = true;
  changed_.notify_all();
}

void Turn::Resume() {
  const std::scoped_lock lock(mutex_);
  resumed_ = true;
}

std::optional<ResumePoint> Turn::newest() const {
  const std::scoped_lock lock(mutex_);
  return newest_;
}

void Turn::OnReader(int64_t source) {
  const std::scoped_lock lock(mutex_);
  if (!readers_.insert(source).second) return;
  new_reader_ = true;
  changed_.notify_all();
}

bool Turn::has_reader() const {
  const std::scoped_lock lock(mutex_);
  return !readers_.empty();
}

void Turn::OnGoBack(int64_t reader, const ResumePoint& frame) {
  const std::scoped_lock lock(mutex_);
  const auto [asked, first] = asked_.try_emplace(reader, frame);
  if (!first && asked->second == frame) return;
  asked->second = frame;
  go_back_ = frame;
  changed_.notify_all();
}

void Turn::Stop() {
  const std::scoped_lock lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

Turn::Event Turn::WaitForPose(Clock::duration limit) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, limit, [this] { return stopped_ || MustRewind() || has_pose_ || new_reader_; });
  if (stopped_) return Event::kStopped;
  if (MustRewind()) return Event::kGoBack;
  go_back_.reset();
  if (has_pose_) return Event::kPose;
  if (!new_reader_) return Event::kTimeout;
  new_reader_ = false;
  return Event::kNewReader;
}

bool Turn::WaitForRewind(Clock::duration limit) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, limit, [this] { return stopped_ || MustRewind(); });
  return !stopped_ && MustRewind();
}

ResumePoint Turn::GoBack() {
  const std::scoped_lock lock(mutex_);
  resumed_ = false;
  newest_ = *std::exchange(go_back_, std::nullopt);
  return *newest_;
}

void Turn::SetPaused(bool paused) {
  const std::scoped_lock lock(mutex_);
  paused_ = paused;
  changed_.notify_all();
}

bool Turn::paused() const {
  const std::scoped_lock lock(mutex_);
  return paused_;
}

Turn::Event Turn::WaitWhilePaused() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return stopped_ || MustRewind() || !paused_; });
  if (stopped_) return Event::kStopped;
  return MustRewind() ? Event::kGoBack : Event::kPose;
}

bool Turn::WaitUntil(Clock::time_point time) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, time, [this] { return stopped_; });
  return !stopped_;
}

bool Turn::stopped() const {
  const std::scoped_lock lock(mutex_);
  return stopped_;
}

}  // namespace plslam::stream
