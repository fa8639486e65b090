// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

namespace plslam::robot {

/// Frame ids that keep ascending when the adapter is killed and restarted, without stored state: they are derived from
/// the stamps. Readers of the bus take a repeated id for the same frame.
class FrameNumbers {
 public:
  int64_t Next(int64_t t_ns) { return last_ = std::max(last_ + 1, t_ns / kTick_ns % kNumbers); }

 private:
  /// One for each frame of cameras of up to 200 Hz.
  static constexpr int64_t kTick_ns = 5'000'000;
  /// Reports store frame ids in 32 bits. The ids start again every 124 days, though not within a process.
  static constexpr int64_t kNumbers = int64_t{1} << 31;

  int64_t last_ = -1;
};

}  // namespace plslam::robot
