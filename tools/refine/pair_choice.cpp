// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/pair_choice.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace plslam::refine {
namespace {

using reference::kPairSize;

// A parameter of the camera is determined if its sigma is at most this share of its prior's.
constexpr double kPairDetermined = 0.5;
// Sigmas by which a parameter must differ from the given camera to be changed.
constexpr double kDiffers = 3.0;
// Iterations of a solve that starts near its optimum.
constexpr int kShortSolve = 8;
// Groups of the jackknife.
constexpr size_t kGroups = 5;

/// The problem without the observations of the keyframes of one of `kGroups` successive groups.
BatchProblem WithoutGroup(const BatchProblem& problem, size_t group) {
  BatchProblem rest = problem;
  const auto is_in = [&](int pose) {
    return static_cast<size_t>(pose) * kGroups / problem.bundle.poses.size() == group;
  };
  for (size_t i = 0; i < rest.point_active.size(); ++i) {
    if (is_in(problem.bundle.point_observations[i].pose)) rest.point_active[i] = 0;
  }
  for (size_t i = 0; i < rest.line_active.size(); ++i) {
    if (is_in(problem.bundle.line_observations[i].pose)) rest.line_active[i] = 0;
  }
  return rest;
}

/// Standard deviations by the delete-a-group jackknife: (K - 1) / K times the sum of squared deviations from the mean.
PairParameters JackknifeSigmas(const BatchProblem& problem, const BatchOptions& options) {
  std::vector<PairParameters> estimates;
  for (size_t group = 0; group < kGroups; ++group) {
    const BatchResult result = SolveBatch(WithoutGroup(problem, group), options);
    if (result.ok) estimates.push_back(result.pair);
  }
  PairParameters sigma{};
  const auto n = static_cast<double>(estimates.size());
  if (n < 2.0) return sigma;
  for (size_t i = 0; i < kPairSize; ++i) {
    double mean = 0.0, squares = 0.0;
    for (const PairParameters& estimate : estimates) mean += estimate[i] / n;
    for (const PairParameters& estimate : estimates) squares += (estimate[i] - mean) * (estimate[i] - mean);
    sigma[i] = std::sqrt((n - 1.0) / n * squares);
  }
  return sigma;
}

/// Leaves one parameter as it was: that determined least if it is not determined, else that which differs least from
/// the given camera if it does not differ. Returns whether there was one.
bool LeaveOne(PairEstimate& pair) {
  const auto worst = [&pair](const auto& badness, double limit) {
    int index = -1;
    for (size_t i = 0; i < kPairSize; ++i) {
      if (pair.state[i] != PairState::kEstimated || badness(i) <= limit) continue;
      limit = badness(i);
      index = static_cast<int>(i);
    }
    return index;
  };
  const auto leave = [&pair](int index, PairState state) {
    const auto i = static_cast<size_t>(index);
    pair.state[i] = state;
    pair.value[i] = 0.0;
    return true;
  };
  const int unknown =
      worst([&pair](size_t i) { return pair.sigma[i] / PairParameterRows()[i].prior_sigma; }, kPairDetermined);
  if (unknown >= 0) return leave(unknown, PairState::kUndetermined);
  const int same =
      worst([&pair](size_t i) { return pair.sigma[i] / std::max(std::abs(pair.value[i]), 1e-300); }, 1.0 / kDiffers);
  return same >= 0 && leave(same, PairState::kAsGiven);
}

}  // namespace

int SolvesOfChoice(const BatchOptions& options) {
  const std::array<bool, kPairSize> free = FreeParameters(options);
  return static_cast<int>(kGroups) + static_cast<int>(std::count(free.begin(), free.end(), true));
}

std::optional<PairEstimate> ChoosePair(const BatchProblem& given, const BatchOptions& given_options) {
  BatchProblem problem = given;
  BatchOptions options = given_options;
  options.max_iterations = kShortSolve;
  PairEstimate pair;
  pair.value = given.pair;
  const std::array<bool, kPairSize> free = FreeParameters(options);
  for (size_t i = 0; i < kPairSize; ++i) pair.state[i] = free[i] ? PairState::kEstimated : PairState::kNotAsked;
  const PairParameters jackknife = JackknifeSigmas(problem, options);
  PairParameters share{};  // of the jackknife's sigma in the formal one, once for all subsets of the parameters
  for (bool first = true;; first = false) {
    for (size_t i = 0; i < kPairSize; ++i) options.pair_free[i] = pair.state[i] == PairState::kEstimated;
    problem.pair = pair.value;
    const BatchResult result = SolveBatch(problem, options);
    if (!result.ok) throw std::runtime_error("the camera cannot be estimated: " + result.reason);
    if (result.stopped) return std::nullopt;
    pair.value = result.pair;
    for (size_t i = 0; i < result.T_w_c.size(); ++i) problem.bundle.poses[i].T_w_c = result.T_w_c[i];
    for (size_t i = 0; i < result.points.size(); ++i) problem.bundle.points[i].p_w = result.points[i];
    for (size_t i = 0; i < result.lines.size(); ++i) problem.bundle.lines[i].segment_w = result.lines[i];
    problem.pair = pair.value;
    const PairParameters formal = PairSigmas(problem, options);
    for (size_t i = 0; i < kPairSize; ++i) {
      if (first) share[i] = formal[i] > 0.0 ? std::max(1.0, jackknife[i] / formal[i]) : 1.0;
      if (pair.state[i] == PairState::kEstimated) pair.sigma[i] = share[i] * formal[i];
    }
    if (!LeaveOne(pair)) return pair;
  }
}

}  // namespace plslam::refine
