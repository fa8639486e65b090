// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/robot/stamp_pairing.h"
#include "ros2/image_rate.h"

namespace plslam::ros2 {

/// Rates of the images of both sides, whose cameras have one rate: a side that misses many images does not show it.
class PairRates {
 public:
  void Add(robot::Side side, int64_t t_ns, size_t n_bytes, double now_s);

  struct Worse {
    robot::Side side = robot::Side::kLeft;
    ImageRate::Rates rates;  ///< of the worse side, sent at the rate of the better one
  };
  Worse OfWorseSide(double now_s);

  /// Counts the images that are missing, at the rate of the better side, and returns those of both since the start.
  /// `is_last`: also the newest steps, of which a lower rate may be the reason.
  int64_t CountMissing(double now_s, bool is_last = false);
  /// Size of the images of a frame: the largest so far.
  int64_t pair_bytes() const { return pair_bytes_; }

 private:
  std::array<ImageRate, 2> rates_;  ///< by side
  int64_t pair_bytes_ = 0;
};

}  // namespace plslam::ros2
