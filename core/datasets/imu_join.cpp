// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/imu_join.h"

#include <iterator>

namespace plslam {

/// Returns whether a time follows the last one of its kind, which it replaces then.
bool ImuJoin::IsInOrder(int64_t t_ns, std::optional<int64_t>& last_ns) {
  if (last_ns && *last_ns - t_ns > kLongestDelay_ns) {
    n_dropped_ += std::ssize(rates_);
    rates_.clear();
    forces_.clear();
    last_rate_ns_.reset();
    last_force_ns_.reset();
  }
  if (last_ns && t_ns <= *last_ns) return false;
  last_ns = t_ns;
  return true;
}

void ImuJoin::AddRate(int64_t t_ns, const Eigen::Vector3d& rate_rad_s) {
  if (IsInOrder(t_ns, last_rate_ns_)) {
    rates_.push_back({t_ns, rate_rad_s, Eigen::Vector3d::Zero()});
  } else {
    ++n_dropped_;
  }
}

void ImuJoin::AddForce(int64_t t_ns, const Eigen::Vector3d& force_m_s2) {
  if (IsInOrder(t_ns, last_force_ns_)) forces_.push_back({t_ns, force_m_s2});
}

/// `forces_` begins with the last one at or before `t_ns`, if there is one, and ends at or after it.
std::optional<Eigen::Vector3d> ImuJoin::ForceAt(int64_t t_ns) const {
  const Force& before = forces_.front();
  if (before.t_ns == t_ns) return before.force_m_s2;
  if (before.t_ns > t_ns || forces_.size() < 2) return std::nullopt;
  const Force& after = forces_[1];
  const int64_t step_ns = after.t_ns - before.t_ns;
  if (step_ns > kLongestForceGap_ns) return std::nullopt;
  const double share = static_cast<double>(t_ns - before.t_ns) / static_cast<double>(step_ns);
  return (1.0 - share) * before.force_m_s2 + share * after.force_m_s2;
}

std::vector<ImuSample> ImuJoin::Take() {
  std::vector<ImuSample> samples;
  for (; !rates_.empty(); rates_.pop_front()) {
    ImuSample& sample = rates_.front();
    const bool has_force = !forces_.empty() && forces_.back().t_ns >= sample.t_ns;
    if (!has_force && rates_.size() <= kMostWaiting) break;
    while (forces_.size() > 1 && forces_[1].t_ns <= sample.t_ns) forces_.pop_front();
    const std::optional<Eigen::Vector3d> force = has_force ? ForceAt(sample.t_ns) : std::nullopt;
    if (force) {
      sample.force_m_s2 = *force;
      samples.push_back(sample);
    } else {
      ++n_dropped_;
    }
  }
  while (forces_.size() > kMostWaiting) forces_.pop_front();
  return samples;
}

}  // namespace plslam
