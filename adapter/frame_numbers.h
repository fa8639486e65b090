// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

namespace plslam::adapter {

/// Numbers of frames that go on ascending when the adapter is killed and started again, without a memory of it: they
/// follow from the stamps. Readers of the bus take a number that they know for the same frame once more.
class FrameNumbers {
 public:
  int64_t Next(int64_t t_ns) { return last_ = std::max(last_ + 1, t_ns / kTick_ns % kNumbers); }

 private:
  /// One for each frame of cameras of up to 200 Hz.
  static constexpr int64_t kTick_ns = 5'000'000;
  /// Reports keep numbers of frames in 32 bits. Every 124 days the numbers begin anew, though not within a process.
  static constexpr int64_t kNumbers = int64_t{1} << 31;

  int64_t last_ = -1;
};

}  // namespace plslam::adapter
