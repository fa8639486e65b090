// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/alignment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/accuracy/consistency.h"
#include "tools/evaluate/trajectory_errors.h"

namespace plslam::evaluate {
namespace {

constexpr int64_t kFineStep_ns = 100'000;
constexpr int kCoarseSteps = 20;  // to each side

/// True and estimated poses.
std::pair<std::vector<SE3>, std::vector<SE3>> Split(const PosePairs& pairs) {
  std::pair<std::vector<SE3>, std::vector<SE3>> poses;
  for (const PosePair& pair : pairs) {
    poses.first.push_back(pair.truth);
    poses.second.push_back(pair.estimate);
  }
  return poses;
}

Trajectory Shifted(Trajectory trajectory, int64_t offset_ns) {
  for (TrajectoryPose& pose : trajectory) pose.t_ns += offset_ns;
  return trajectory;
}

/// Returns the poses that have a truth at both ends of the search and without an offset.
Trajectory AlwaysPaired(const Trajectory& estimate, const Trajectory& truth, int64_t max_gap_ns, int64_t max_ns) {
  std::vector<int> ends(estimate.size(), 0);
  for (const int64_t offset_ns : {-max_ns, int64_t{0}, max_ns}) {
    for (const PosePair& pair : AssociateInterpolated(Shifted(estimate, offset_ns), truth, max_gap_ns)) {
      ++ends[static_cast<size_t>(pair.estimate_index)];
    }
  }
  Trajectory paired;
  for (size_t i = 0; i < estimate.size(); ++i) {
    if (ends[i] == 3) paired.push_back(estimate[i]);
  }
  return paired;
}

/// Returns the position of the least value among `center` and `n` steps to each side; `center` if none is less.
int64_t LeastAround(int64_t center, int64_t step, int n, const std::function<double(int64_t)>& value) {
  int64_t best = center;
  double least = value(center);
  for (int i = -n; i <= n; ++i) {
    const double here = value(center + i * step);
    if (here < least) {
      least = here;
      best = center + i * step;
    }
  }
  return best;
}

}  // namespace

Similarity Align(const PosePairs& pairs, Alignment alignment) {
  if (pairs.empty() || alignment == Alignment::kNone) return {};
  if (alignment == Alignment::kFirst) return {1.0, pairs[0].truth * pairs[0].estimate.Inverse()};
  const auto [truth, estimate] = Split(pairs);
  return AlignPaths(truth, estimate, alignment == Alignment::kSim3);
}

Eigen::Quaterniond AlignOrientations(const PosePairs& pairs, Alignment alignment) {
  if (!IsLeastSquares(alignment)) return Align(pairs, alignment).T_a_b.rotation();
  const auto [truth, estimate] = Split(pairs);
  return plslam::AlignOrientations(truth, estimate);
}

std::optional<ClockOffset> FitClockOffset(const Trajectory& estimate, const Trajectory& truth, Alignment alignment,
                                          int64_t max_gap_ns, double max_s) {
  const auto max_ns = static_cast<int64_t>(std::llround(1e9 * max_s));
  const auto can_move = [max_ns](const TrajectoryPose& pose) {
    return pose.t_ns > std::numeric_limits<int64_t>::min() + max_ns &&
           pose.t_ns < std::numeric_limits<int64_t>::max() - max_ns;
  };
  if (!std::all_of(estimate.begin(), estimate.end(), can_move)) return std::nullopt;
  const Trajectory paired = AlwaysPaired(estimate, truth, max_gap_ns, max_ns);
  if (paired.size() < 3 || max_ns < kFineStep_ns) return std::nullopt;
  const auto ate_m = [&](int64_t offset_ns) {
    const PosePairs pairs = AssociateInterpolated(Shifted(paired, offset_ns), truth, max_gap_ns);
    const Eigen::Quaterniond any = Eigen::Quaterniond::Identity();
    return Summarise(ComputeAbsoluteErrors(pairs, Align(pairs, alignment), any).translation_m).rmse;
  };
  const int64_t coarse_ns = std::max(max_ns / kCoarseSteps, kFineStep_ns);
  const int64_t near_ns = LeastAround(0, coarse_ns, static_cast<int>(max_ns / coarse_ns), ate_m);
  if (std::abs(near_ns) + coarse_ns > max_ns) return std::nullopt;
  const int64_t best_ns = LeastAround(near_ns, kFineStep_ns, static_cast<int>(coarse_ns / kFineStep_ns), ate_m);
  return ClockOffset{1e-9 * static_cast<double>(best_ns), ate_m(best_ns), ate_m(0)};
}

}  // namespace plslam::evaluate
