// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/places/revisits.h"

#include <cmath>
#include <numbers>

namespace plslam {

PairTruth ClassifyPair(const TimedPose& a, const TimedPose& b, const RevisitOptions& options) {
  const double gap_s = 1e-9 * std::abs(static_cast<double>(a.t_ns - b.t_ns));
  if (gap_s < options.min_gap_s) return PairTruth::kIgnored;
  const double distance_m = (a.T_w_c.translation() - b.T_w_c.translation()).norm();
  const double angle_deg = a.T_w_c.rotation().angularDistance(b.T_w_c.rotation()) * 180.0 / std::numbers::pi;
  if (distance_m <= options.distance_m && angle_deg <= options.angle_deg) return PairTruth::kRevisit;
  const bool far = distance_m > options.far_distance_m || angle_deg > options.far_angle_deg;
  return far ? PairTruth::kOtherPlace : PairTruth::kIgnored;
}

}  // namespace plslam
