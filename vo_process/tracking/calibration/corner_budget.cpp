// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/corner_budget.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace plslam::vo {
namespace {

// Share of useful corners among the strongest, below which the budget grows, and above which it returns to normal. Snow
// of 250 streaks leaves a fifth; on real sequences in good weather the share was never below 65 per cent.
constexpr double kFewOfUse = 0.4;
constexpr double kMostOfUse = 0.6;
// Largest factor of the budget; more corners take more time than they are worth.
constexpr double kMaxFactor = 4.0;
// The same if moving bodies have most of the corners, which are useful ones: twice as many leave enough of the world.
constexpr double kMaxBodyFactor = 2.0;
// Share of the usual number of corners below which the image has no more, so that a larger budget is useless.
constexpr double kBudgetUsedUp = 0.9;

/// Indices of the corners that a budget of `count` would, approximately, have kept.
std::vector<size_t> Strongest(const std::vector<StereoPoint>& points, size_t count) {
  std::vector<size_t> strongest(points.size());
  std::iota(strongest.begin(), strongest.end(), size_t{0});
  if (count >= points.size()) return strongest;
  const auto stronger = [&points](size_t a, size_t b) {
    const float response_a = points[a].left.response;
    const float response_b = points[b].left.response;
    return response_a != response_b ? response_a > response_b : a < b;
  };
  const auto last = strongest.begin() + static_cast<std::ptrdiff_t>(count);
  std::nth_element(strongest.begin(), last, strongest.end(), stronger);
  strongest.erase(last, strongest.end());
  return strongest;
}

}  // namespace

void CornerBudget::Observe(const TrackedFrame& frame) {
  const std::vector<StereoPoint>& points = frame.features.points;
  if (usual_ == 0 || static_cast<double>(points.size()) < kBudgetUsedUp * usual_) {
    factor_ = 1.0;
    return;
  }
  const std::vector<size_t> strongest = Strongest(points, static_cast<size_t>(usual_));
  const auto is_on_body = [&](size_t i) { return !frame.point_tracks[i].IsOfWorld(); };
  const auto is_of_use = [&](size_t i) {
    return points[i].HasDepth() || (frame.point_tracks[i].landmark_id >= 0 && frame.point_tracks[i].age > 0);
  };
  const auto share_of = [&](const auto& is_such) {
    return static_cast<double>(std::count_if(strongest.begin(), strongest.end(), is_such)) /
           static_cast<double>(strongest.size());
  };
  const double of_use = share_of(is_of_use);
  const double of_world = share_of([&](size_t i) { return is_of_use(i) && !is_on_body(i); });
  const double enough = factor_ > 1.0 ? kMostOfUse : kFewOfUse;
  factor_ = 1.0;
  if (of_world < enough) factor_ = std::min(1.0 / std::max(of_world, 1e-3), kMaxBodyFactor);
  if (of_use < enough) factor_ = std::min(1.0 / std::max(of_use, 1e-3), kMaxFactor);
}

}  // namespace plslam::vo
