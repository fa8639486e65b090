// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/imu_queue.h"

#include <algorithm>
#include <cstddef>
#include <span>

namespace plslam::robot {

void ImuQueue::Add(const ImuSample& sample) {
  const std::scoped_lock lock(mutex_);
  Insert(sample);
}

void ImuQueue::AddRate(int64_t t_ns, const Eigen::Vector3d& rate_rad_s) {
  const std::scoped_lock lock(mutex_);
  join_.AddRate(t_ns, rate_rad_s);
  InsertJoined();
}

void ImuQueue::AddForce(int64_t t_ns, const Eigen::Vector3d& force_m_s2) {
  const std::scoped_lock lock(mutex_);
  join_.AddForce(t_ns, force_m_s2);
  InsertJoined();
}

void ImuQueue::InsertJoined() {
  for (const ImuSample& sample : join_.Take()) Insert(sample);
}

void ImuQueue::Insert(const ImuSample& sample) {
  ++counts_.n;
  if (!samples_.empty() && samples_.back().t_ns - sample.t_ns > kLongestDelay_ns) {
    samples_.clear();
    taken_ns_ = std::numeric_limits<int64_t>::min();
  }
  const auto is_before = [](const ImuSample& a, int64_t t_ns) { return a.t_ns < t_ns; };
  const auto at = std::lower_bound(samples_.begin(), samples_.end(), sample.t_ns, is_before);
  if (at != samples_.end() && at->t_ns == sample.t_ns) {
    ++counts_.n_repeated;
    return;
  }
  counts_.n_late += sample.t_ns <= taken_ns_;
  samples_.insert(at, sample);
  if (samples_.size() > kMostSamples) samples_.erase(samples_.begin());
}

bool ImuQueue::Covers(int64_t t_ns) const {
  const std::scoped_lock lock(mutex_);
  return !samples_.empty() && samples_.back().t_ns >= t_ns;
}

std::vector<ImuSample> ImuQueue::Take(int64_t from_ns, int64_t to_ns) {
  const std::scoped_lock lock(mutex_);
  const std::span<const ImuSample> motion = SamplesOfMotion(samples_, from_ns, to_ns);
  std::vector<ImuSample> taken(motion.begin(), motion.end());
  taken_ns_ = to_ns;
  const auto n_past = motion.empty() ? 0 : motion.data() - samples_.data();
  samples_.erase(samples_.begin(), samples_.begin() + n_past);
  return taken;
}

ImuQueue::Counts ImuQueue::counts() const {
  const std::scoped_lock lock(mutex_);
  return counts_;
}

std::optional<int64_t> ImuQueue::newest_ns() const {
  const std::scoped_lock lock(mutex_);
  return samples_.empty() ? std::nullopt : std::optional(samples_.back().t_ns);
}

}  // namespace plslam::robot
