// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/pair_choice.h"

#include <algorithm>
#include <cmath>
#include <numeric>
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
// Iterations of a solve of some keyframes, with the camera of the others or the given one.
constexpr int kHeldOutSolve = 15;
// Groups of the jackknife and of the cross-validation.
constexpr size_t kGroups = 5;

/// The problem without the observations of the keyframes of one of `kGroups` successive groups, and with these only.
struct Split {
  BatchProblem rest;
  BatchProblem only;
};

Split SplitOff(const BatchProblem& problem, size_t group) {
  Split split{problem, problem};
  const auto without = [&](int pose) -> BatchProblem& {
    const bool is_in = static_cast<size_t>(pose) * kGroups / problem.bundle.poses.size() == group;
    return is_in ? split.rest : split.only;
  };
  for (size_t i = 0; i < problem.point_active.size(); ++i) {
    without(problem.bundle.point_observations[i].pose).point_active[i] = 0;
  }
  for (size_t i = 0; i < problem.line_active.size(); ++i) {
    without(problem.bundle.line_observations[i].pose).line_active[i] = 0;
  }
  return split;
}

/// Standard deviations by the delete-a-group jackknife: (K - 1) / K times the sum of squared deviations from the mean.
PairParameters JackknifeSigmas(const BatchProblem& problem, const BatchOptions& options) {
  std::vector<PairParameters> estimates;
  for (size_t group = 0; group < kGroups; ++group) {
    const BatchResult result = SolveBatch(SplitOff(problem, group).rest, options);
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

/// Whether keyframes confirm a change of the camera that the others estimate: with it, the keyframes of each group alone
/// agree better with each other than with the given camera, by more than one standard error of the sum over the groups
/// (cross-validation with the one-standard-error rule of Breiman et al., 1984). Noise does not predict, however
/// significant it looks where it was estimated. Returns nullopt if it was stopped.
std::optional<bool> IsConfirmed(const BatchProblem& problem, BatchOptions options) {
  options.max_iterations = kHeldOutSolve;
  std::vector<double> gains;
  for (size_t group = 0; group < kGroups; ++group) {
    Split split = SplitOff(problem, group);
    const BatchResult rest = SolveBatch(split.rest, options);
    BatchOptions constant = options;
    constant.pair_free.fill(false);
    split.only.pair = rest.pair;
    const BatchResult predicted = SolveBatch(split.only, constant);
    split.only.pair = {};
    const BatchResult given = SolveBatch(split.only, constant);
    if (rest.stopped || predicted.stopped || given.stopped) return std::nullopt;
    if (rest.ok && predicted.ok && given.ok) gains.push_back(given.cost_after - predicted.cost_after);
  }
  const auto n = static_cast<double>(gains.size());
  if (n < 2.0) return false;
  const double mean = std::accumulate(gains.begin(), gains.end(), 0.0) / n;
  double squares = 0.0;
  for (const double gain : gains) squares += (gain - mean) * (gain - mean);
  return mean > std::sqrt(squares / (n - 1.0) / n);
}

/// The estimated parameter for which `badness` is largest, and above `limit`; nullopt if there is none.
template <class Badness>
std::optional<size_t> Worst(const PairEstimate& pair, double limit, const Badness& badness) {
  std::optional<size_t> worst;
  for (size_t i = 0; i < kPairSize; ++i) {
    if (pair.state[i] != PairState::kEstimated || badness(i) <= limit) continue;
    limit = badness(i);
    worst = i;
  }
  return worst;
}

/// Sigmas by the difference from the given camera.
double Insignificance(const PairEstimate& pair, size_t i) {
  return pair.sigma[i] / std::max(std::abs(pair.value[i]), 1e-300);
}

void Leave(size_t i, PairState state, PairEstimate& pair) {
  pair.state[i] = state;
  pair.value[i] = 0.0;
}

/// Leaves one parameter as it was: that determined least if it is not determined, else that which differs least from
/// the given camera if it does not differ. Returns whether there was one.
bool LeaveOne(PairEstimate& pair) {
  const auto unknown =
      Worst(pair, kPairDetermined, [&](size_t i) { return pair.sigma[i] / PairParameterRows()[i].prior_sigma; });
  if (unknown) Leave(*unknown, PairState::kUndetermined, pair);
  if (unknown) return true;
  const auto same = Worst(pair, 1.0 / kDiffers, [&](size_t i) { return Insignificance(pair, i); });
  if (same) Leave(*same, PairState::kAsGiven, pair);
  return same.has_value();
}

}  // namespace

int SolvesOfChoice(const BatchOptions& options) {
  const std::array<bool, kPairSize> free = FreeParameters(options);
  // The jackknife, a solve for each parameter, and a confirmation.
  constexpr auto kGroupsInt = static_cast<int>(kGroups);
  return kGroupsInt + static_cast<int>(std::count(free.begin(), free.end(), true)) + 3 * kGroupsInt;
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
    if (LeaveOne(pair)) continue;
    const auto least = Worst(pair, 0.0, [&](size_t i) { return Insignificance(pair, i); });
    if (!least) return pair;
    const std::optional<bool> confirmed = IsConfirmed(problem, options);
    if (!confirmed) return std::nullopt;
    if (*confirmed) return pair;
    Leave(*least, PairState::kUnconfirmed, pair);
  }
}

}  // namespace plslam::refine
