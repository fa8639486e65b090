// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <vector>

#include "core/datasets/imu_join.h"
#include "core/geometry/imu.h"

namespace plslam::robot {

/// Samples of a live inertial sensor between their arrival and the frames that they lead to. All times are of the
/// sensor's clock. Samples may arrive in another order than they were measured. A stamp that goes back by more than
/// `kLongestDelay_ns` means that the clock was set back: earlier samples are dropped. Safe from any thread.
class ImuQueue {
 public:
  static constexpr int64_t kLongestDelay_ns = 1'000'000'000;

  struct Counts {
    int64_t n = 0;           ///< samples that arrived
    int64_t n_late = 0;      ///< of these, after the frame that they lead to was sent
    int64_t n_repeated = 0;  ///< of these, with the stamp of another one; they are dropped
  };

  void Add(const ImuSample& sample);
  /// Add a sensor whose rates and forces arrive apart (`ImuJoin`).
  void AddRate(int64_t t_ns, const Eigen::Vector3d& rate_rad_s);
  void AddForce(int64_t t_ns, const Eigen::Vector3d& force_m_s2);

  /// Returns whether a sample at or after this time has arrived, so that the motion before it is complete.
  bool Covers(int64_t t_ns) const;
  /// Returns the samples of a motion that have arrived (`SamplesOfMotion`), and drops those before it: motions that are
  /// taken later begin no earlier, but may contain it, when its samples have arrived.
  std::vector<ImuSample> Take(int64_t from_ns, int64_t to_ns);

  Counts counts() const;
  /// Time of the newest sample; nullopt if there is none.
  std::optional<int64_t> newest_ns() const;

 private:
  /// Samples that wait: ten seconds of a fast sensor.
  static constexpr size_t kMostSamples = 20'000;

  void Insert(const ImuSample& sample);
  void InsertJoined();

  mutable std::mutex mutex_;
  ImuJoin join_;
  std::vector<ImuSample> samples_;                          ///< in order of increasing time
  int64_t taken_ns_ = std::numeric_limits<int64_t>::min();  ///< end of the last motion
  Counts counts_;
};

}  // namespace plslam::robot
