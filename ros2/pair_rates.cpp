// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/pair_rates.h"

#include <algorithm>

namespace plslam::ros2 {

void PairRates::Add(robot::Side side, int64_t t_ns, size_t n_bytes, double now_s) {
  pair_bytes_ = std::max(pair_bytes_, 2 * static_cast<int64_t>(n_bytes));
  rates_[static_cast<size_t>(side)].Add(t_ns, now_s);
}

PairRates::Worse PairRates::OfWorseSide(double now_s) {
  const ImageRate::Rates left = rates_[0].Of(now_s), right = rates_[1].Of(now_s);
  const bool right_is_worse = right.arrived_hz > 0.0 && right.arrived_hz < left.arrived_hz;
  return {.side = right_is_worse ? robot::Side::kRight : robot::Side::kLeft,
          .rates = {.sent_hz = std::max(left.sent_hz, right.sent_hz),
                    .arrived_hz = right_is_worse ? right.arrived_hz : left.arrived_hz}};
}

int64_t PairRates::CountMissing(double now_s, bool is_last) {
  const ImageRate::Rates left = rates_[0].Of(now_s), right = rates_[1].Of(now_s);
  ImageRate::Rates better = right.sent_hz > left.sent_hz ? right : left;
  if (is_last) better.to_ns = INT64_MAX;
  if (better.sent_hz > 0.0) {
    for (ImageRate& rate : rates_) rate.CountMissing(better);
  }
  return rates_[0].n_missing() + rates_[1].n_missing();
}

}  // namespace plslam::ros2
