// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/run_paths.h"

#include <stdexcept>
#include <utility>

#include "core/accuracy/association.h"
#include "tools/evaluate/accuracy.h"

namespace plslam::evaluate {
namespace {

/// Returns the transform from the frame of `estimate` to that of `reference`; nullopt if they have no moment in common.
std::optional<SE3> Join(const Trajectory& estimate, const Trajectory& reference) {
  if (reference.empty() || AssociateNearest(estimate, reference, kSameMoment_ns).empty()) return std::nullopt;
  return EvaluateTrajectory(estimate, reference, {}).alignment.T_a_b;
}

}  // namespace

std::optional<Run> FindRunPaths(const std::string& folder) {
  for (const unsigned content : {run_content::kTrajectory | run_content::kTruth, run_content::kTrajectory}) {
    try {
      Run run = ReadRun(folder, content);
      return run.has_poses() ? std::optional(std::move(run)) : std::nullopt;
    } catch (const std::runtime_error&) {
      continue;  // The truth may be the damaged one.
    }
  }
  return std::nullopt;
}

std::optional<SE3> TruthFromMap(const Run& run) {
  return run.truth ? Join(*run.trajectory, *run.truth) : std::nullopt;
}

SE3 BaseFromOther(const Run& base, const Run& other) {
  const std::optional<SE3> T_truth_base = TruthFromMap(base), T_truth_other = TruthFromMap(other);
  if (T_truth_base && T_truth_other) return T_truth_base->Inverse() * *T_truth_other;
  return Join(*other.trajectory, *base.trajectory).value_or(SE3());
}

}  // namespace plslam::evaluate
