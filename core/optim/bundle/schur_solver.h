// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/optim/bundle/camera_view.h"
#include "core/optim/bundle/eliminated_landmarks.h"
#include "core/optim/bundle/inertial_chain.h"
#include "core/optim/bundle/relative_poses.h"
#include "core/optim/bundle/step_control.h"
#include "core/optim/solver/trust_region.h"

namespace plslam {

/// Levenberg-Marquardt on poses, points and lines with landmarks eliminated (Schur complement). Takes the same steps as
/// the Schur solvers of Ceres, in a third of the time, because all block sizes are known at compile time. The remaining
/// system of the poses is dense for at most `max_dense_poses` of them, sparse for more.
class SchurSolver {
 public:
  /// All arguments must outlive it.
  SchurSolver(std::vector<AdjustedPose>& poses, const RelativePoses& relative, const InertialChain& inertial,
              const std::array<EliminatedLandmarks*, 2>& kinds, const BundleOptions& options);

  /// Takes steps from the current state until `control` ends the pass; leaves the best state found. Trims outliers if
  /// `trim`. Fails if the system cannot be solved for any damping. It has converged, not failed (as in Ceres), if steps
  /// no longer predict a reduction.
  BundlePass Run(StepControl& control, bool trim);

 private:
  double Linearise();
  double Loss() const;
  bool IsFlat() const;
  /// Returns the predicted reduction of the loss; if it is not positive, the state has not changed. Returns nullopt if
  /// the system cannot be solved.
  std::optional<double> Step(const Damping& damping);
  void RollBack();

  std::vector<AdjustedPose>& poses_;
  const RelativePoses& relative_;
  const InertialChain& inertial_;
  std::array<EliminatedLandmarks*, 2> kinds_;
  const BundleOptions& options_;
  std::vector<Vector6d> before_;
  PoseSystem system_;
  PoseSystem reduced_;
};

}  // namespace plslam
