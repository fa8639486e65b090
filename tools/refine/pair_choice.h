// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "tools/refine/batch_problem.h"

namespace plslam::refine {

/// Outcome of a parameter of the camera.
enum class PairState {
  kNotAsked,
  kEstimated,
  /// Its sigma is above half of that of its weak prior: left as it was.
  kUndetermined,
  /// It differs from the given camera by less than three sigmas: left as it was.
  kAsGiven,
  /// It differs by more, but keyframes without which it was estimated do not agree better with it: left as it was.
  kUnconfirmed
};

/// Estimate of the camera's parameters, as deviations from the ideal pair that the map was made with. Sigmas are those
/// of the residuals, times the factor by which those of the estimates without one fifth of the keyframes each
/// (delete-a-group jackknife) are larger when all parameters are estimated: errors that observations have in common (a
/// disparity that is wrong in the same way in each view) make the former too small.
struct PairEstimate {
  PairParameters value{};
  PairParameters sigma{};
  std::array<PairState, reference::kPairSize> state{};
};

/// Estimates the camera at a problem near its optimum, and decides which parameters are kept: the one that is determined
/// least, or differs least from the given camera in sigmas, is left as it was, and the rest estimated again, until all
/// are determined and differ, and keyframes without which they are estimated confirm the change. Each of these is a short
/// solve; the jackknife takes five, and each confirmation fifteen of parts. Returns nullopt if it was stopped before the
/// choice was complete. Throws std::runtime_error if the solver fails.
std::optional<PairEstimate> ChoosePair(const BatchProblem& problem, const BatchOptions& options);

/// Usual number of solves of `ChoosePair`.
int SolvesOfChoice(const BatchOptions& options);

}  // namespace plslam::refine
