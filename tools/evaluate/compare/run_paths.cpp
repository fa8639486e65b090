// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/run_paths.h"

#include <filesystem>
#include <stdexcept>
#include <string>

#include "core/accuracy/association.h"
#include "tools/evaluate/accuracy.h"

namespace plslam::evaluate {
namespace {

Trajectory TryRead(const std::string& path) {
  if (!std::filesystem::exists(path)) return {};
  try {
    return ReadTrajectory(path, TrajectoryFormat::kTum);
  } catch (const std::runtime_error&) {
    return {};
  }
}

/// Returns the transform from the frame of `estimate` to that of `reference`; nullopt if they have no moment in common.
std::optional<SE3> Join(const Trajectory& estimate, const Trajectory& reference) {
  if (reference.empty() || AssociateNearest(estimate, reference, kSameMoment_ns).empty()) return std::nullopt;
  return EvaluateTrajectory(estimate, reference, {}).alignment.T_a_b;
}

}  // namespace

std::optional<RunPaths> ReadRunPaths(const RunRecord& run) {
  RunPaths paths;
  paths.estimate = TryRead(run.folder + "/trajectory.tum");
  if (paths.estimate.empty()) return std::nullopt;
  paths.truth = TryRead(run.folder + "/groundtruth.tum");
  paths.T_truth_w = Join(paths.estimate, paths.truth);
  return paths;
}

SE3 BaseFromOther(const RunPaths& base, const RunPaths& other) {
  if (base.T_truth_w && other.T_truth_w) return base.T_truth_w->Inverse() * *other.T_truth_w;
  return Join(other.estimate, base.estimate).value_or(SE3());
}

}  // namespace plslam::evaluate
