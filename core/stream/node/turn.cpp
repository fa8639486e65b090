// SPDX-License-Identifier: BSD-3-Clause
#include "core/stream/node/turn.h"

#include <utility>

namespace plslam::stream {

void Turn::Expect(const ResumePoint& frame) {
  const std::scoped_lock lock(mutex_);
  expected_ = frame;
  const bool has_pose = resumed_ && newest_ && newest_->frame_id >= frame.frame_id && newest_->t_ns >= frame.t_ns;
  answer_ = has_pose ? Answer::kPose : Answer::kAwaited;
}

void Turn::OnPose(const ResumePoint& frame) {
  const std::scoped_lock lock(mutex_);
  if (!newest_ || newest_->frame_id < frame.frame_id) newest_ = frame;
  if (!expected_ || expected_->frame_id != frame.frame_id) return;
  answer_ = Answer::kPose;
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

void Turn::OnReader(SourceId source) {
  const std::scoped_lock lock(mutex_);
  if (!readers_.insert(source).second) return;
  if (answer_ == Answer::kAwaited) answer_ = Answer::kNewReader;
  changed_.notify_all();
}

bool Turn::has_reader() const {
  const std::scoped_lock lock(mutex_);
  return !readers_.empty();
}

void Turn::OnGoBack(SourceId reader, const ResumePoint& frame) {
  const std::scoped_lock lock(mutex_);
  const auto [asked, first] = asked_.try_emplace(reader, frame);
  if (!first && asked->second == frame) return;
  asked->second = frame;
  go_back_ = frame;
  changed_.notify_all();
}

void Turn::Stop() {
  const std::scoped_lock lock(mutex_);
  course_ = Course::kStopped;
  changed_.notify_all();
}

Turn::Event Turn::WaitForPose(Clock::duration limit) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, limit, [this] { return MustEndWait() || answer_ != Answer::kAwaited; });
  if (course_ == Course::kStopped) return Event::kStopped;
  if (MustRewind()) return Event::kGoBack;
  go_back_.reset();
  if (answer_ == Answer::kPose) return Event::kPose;
  return std::exchange(answer_, Answer::kAwaited) == Answer::kNewReader ? Event::kNewReader : Event::kTimeout;
}

bool Turn::WaitForRewind(Clock::duration limit) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, limit, [this] { return MustEndWait(); });
  return course_ != Course::kStopped && MustRewind();
}

ResumePoint Turn::GoBack() {
  const std::scoped_lock lock(mutex_);
  resumed_ = false;
  newest_ = *std::exchange(go_back_, std::nullopt);
  return *newest_;
}

void Turn::SetPaused(bool paused) {
  const std::scoped_lock lock(mutex_);
  if (course_ == Course::kStopped) return;
  course_ = paused ? Course::kPaused : Course::kRunning;
  changed_.notify_all();
}

bool Turn::is_running() const {
  const std::scoped_lock lock(mutex_);
  return course_ == Course::kRunning;
}

Turn::Event Turn::WaitWhilePaused() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return MustEndWait() || course_ == Course::kRunning; });
  if (course_ == Course::kStopped) return Event::kStopped;
  return MustRewind() ? Event::kGoBack : Event::kPose;
}

bool Turn::WaitUntil(Clock::time_point time) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, time, [this] { return course_ == Course::kStopped; });
  return course_ != Course::kStopped;
}

bool Turn::stopped() const {
  const std::scoped_lock lock(mutex_);
  return course_ == Course::kStopped;
}

}  // namespace plslam::stream
