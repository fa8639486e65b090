// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/optim/bundle/camera_view.h"
#include "core/optim/bundle/eliminated_landmarks.h"
#include "core/optim/bundle/relative_poses.h"
#include "core/optim/bundle/step_control.h"
#include "core/optim/solver/trust_region.h"

namespace plslam {

/// Levenberg-Marquardt on poses, points and lines with landmarks eliminated (Schur complement): what Ceres does with
/// its Schur solvers, step for step, in a third of the time, because the sizes of all blocks are known to the
/// compiler. The system of the poses that is left is dense for at most `max_dense_poses`, sparse for more.
class SchurSolver {
 public:
  /// All must outlive it.
  SchurSolver(std::vector<AdjustedPose>& poses, const RelativePoses& relative,
              const std::array<EliminatedLandmarks*, 2>& kinds, const BundleOptions& options);

  /// Steps from the state as it is until `control` has enough; leaves the best state found. Outliers are trimmed if
  /// `trim`. Fails where the system cannot be solved, however short the step. Where steps promise no gain any more,
  /// which Ceres calls a failure too, it is at its end.
  BundlePass Run(StepControl& control, bool trim);

 private:
  double Linearise();
  double Loss() const;
  bool IsFlat() const;
  /// Returns the gain predicted_reduction; where that is not above 0, nothing has moved. nullopt where the system
  /// cannot be solved.
  std::optional<double> Step(const Damping& damping);
  void TakeBack();

  std::vector<AdjustedPose>& poses_;
  const RelativePoses& relative_;
  std::array<EliminatedLandmarks*, 2> kinds_;
  const BundleOptions& options_;
  std::vector<Vector6d> before_;
  PoseSystem system_;
  PoseSystem reduced_;
};

}  // namespace plslam
