#pragma once

#include <Eigen/Core>

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "core/geometry/se3.h"
#include "core/optim/bundle/camera_view.h"
#include "core/optim/bundle/eliminated_landmarks.h"
#include "core/optim/bundle/relative_poses.h"
#include "core/optim/bundle/step_judge.h"

namespace plslam {

/// Normal equations H x = -g of the free poses, six rows for each. Only the lower triangle of H's blocks is kept.
struct PoseSystem {
  explicit PoseSystem(int pose_count)
      : H(Eigen::MatrixXd::Zero(6 * pose_count, 6 * pose_count)), g(Eigen::VectorXd::Zero(6 * pose_count)) {}

  void SetZero() {
    H.setZero();
    g.setZero();
  }

  auto Diagonal(int pose) { return H.block<6, 6>(6 * pose, 6 * pose); }
  auto Gradient(int pose) { return g.segment<6>(6 * pose); }
  /// Of two different poses, the later one's rows.
  auto Below(int earlier, int later) { return H.block<6, 6>(6 * later, 6 * earlier); }

  Eigen::MatrixXd H;
  Eigen::VectorXd g;
};

/// How far steps are trusted, as Ceres has it: K. Madsen, H. B. Nielsen, O. Tingleff, "Methods for non-linear least squares
/// problems" (2004), 3.2.
class TrustRegion {
 public:
  Damping damping() const { return {1.0 / radius_}; }
  /// `quality`: gain of the step over what was foretold.
  void Accepted(double quality);
  void Rejected();

 private:
  double radius_ = 1e4;
  double shrink_ = 2.0;
};

/// Levenberg-Marquardt on poses, points and lines with landmarks eliminated and a dense system of the poses: what Ceres
/// does with its dense Schur complement, step for step, in a third of the time, because the sizes of all blocks
/// are known to the compiler. Time grows with the cube of the free poses: for many there is `CeresSolver`.
class SchurSolver {
 public:
  /// All must outlive it.
  SchurSolver(std::vector<AdjustedPose>& poses, const RelativePoses& relative,
              const std::array<EliminatedLandmarks*, 2>& kinds, const BundleOptions& options);

  /// Steps from the state as it is until `judge` has enough; leaves the best state found. Outliers are trimmed if `trim`.
  /// Fails where the system cannot be solved, however short the step. Where steps promise no gain any more, which Ceres
  /// calls a failure too, it is at its end.
  BundlePass Run(StepJudge& judge, bool trim);

 private:
  double Linearise();
  double Loss() const;
  bool IsFlat() const;
  /// Returns the gain foretold; where that is not above 0, nothing has moved. nullopt where the system cannot be solved.
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
