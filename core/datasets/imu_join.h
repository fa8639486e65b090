// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/imu.h"

namespace plslam {

/// Joins angular rates and specific forces that a sensor publishes apart, each at its own rate (RealSense: 200 or 400
/// and 63 to 250 Hz): the force is interpolated at the stamp of each rate.
///
/// Rates and forces come in order of increasing time, and in any order to each other; others are dropped. A rate waits
/// for a force at or after it, and is dropped if it has none before it, or if the two are further apart than
/// `kLongestForceGap_ns`. Times that go back by more than `kLongestDelay_ns` are of a clock that was set back: all that
/// waits is dropped.
class ImuJoin {
 public:
  static constexpr int64_t kLongestForceGap_ns = 100'000'000;
  static constexpr int64_t kLongestDelay_ns = 1'000'000'000;

  void AddRate(int64_t t_ns, const Eigen::Vector3d& rate_rad_s);
  void AddForce(int64_t t_ns, const Eigen::Vector3d& force_m_s2);

  /// Returns the samples that are complete since the last call, in order of increasing time.
  std::vector<ImuSample> Take();

  /// Number of rates that were dropped.
  int64_t n_dropped() const { return n_dropped_; }

 private:
  /// Rates wait for forces that do not come: this many at most.
  static constexpr size_t kMostWaiting = 10'000;

  struct Force {
    int64_t t_ns = 0;
    Eigen::Vector3d force_m_s2 = Eigen::Vector3d::Zero();
  };

  bool IsInOrder(int64_t t_ns, std::optional<int64_t>& last_ns);
  std::optional<Eigen::Vector3d> ForceAt(int64_t t_ns) const;

  std::deque<ImuSample> rates_;  ///< without forces
  std::deque<Force> forces_;
  std::optional<int64_t> last_rate_ns_, last_force_ns_;
  int64_t n_dropped_ = 0;
};

}  // namespace plslam
