// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/camera_view.h"
#include "core/optim/bundle/pose_system.h"

namespace plslam {

/// The inertial motions of an adjustment: what accelerations say about the positions of successive poses.
///
/// The motion from pose i of the sensor to pose j, over a time t, has two residuals (Forster et al. 2017, §VI) with
/// rotations R, positions p and velocities v, gravity g, and the bias b of the specific force, whitened together:
///
///   R_i^T (v_j - v_i - g t) - dv(b)        R_i^T (p_j - p_i - v_i t - g t^2 / 2) - dp(b)
///
/// Velocities, one bias for each chain of successive motions, and gravity are states of the chain. Given the poses they
/// are a linear problem, so they are eliminated (variable projection): loss, gradient and information are those at the
/// best states, and an adjustment sees functions of its poses alone. The loss of a motion is pseudo-Huber; its weights
/// are found by iteration.
///
/// The rotation of the gyroscope is not among the residuals, because the trackers' motions in the adjustment
/// (`RelativePose`) contain it.
class InertialChain {
 public:
  /// Residual at which the loss becomes linear, in standard deviations.
  static constexpr double kDelta = 3.0;

  /// `poses` must outlive it. Ignores motions of poses without observations.
  InertialChain(const BundleProblem& problem, std::vector<AdjustedPose>& poses);

  /// Adds information and gradient at the current poses. Returns the loss.
  double Linearise(PoseSystem& system) const;
  /// Twice the cost at the current poses.
  double Loss() const;

  /// Marks its poses as `constant`.
  void HoldPoses();

 private:
  using Residual = Vector6d;
  using ByState = Eigen::Matrix<double, 6, 3>;

  struct Link {
    AdjustedPose* a;
    AdjustedPose* b;
    SE3 T_c_imu;
    double t_s;
    Eigen::Vector3d dv_m_s;
    Eigen::Vector3d dp_m;
    Matrix6d whitening;
    ByState by_bias;
    /// First rows of its states: gravity, both velocities, and the bias.
    std::array<int, 4> rows;
  };
  /// A link at the current poses: r0 + sum of by_state[i] times its states; all whitened.
  struct LinkNow {
    Residual r0;
    std::array<ByState, 4> by_state;
    double weight = 1.0;

    Residual At(const Link& link, const Eigen::VectorXd& states) const;
  };
  /// The best states given the current poses.
  struct Solution {
    std::vector<LinkNow> links;
    Eigen::LLT<Eigen::MatrixXd> information;
    Eigen::VectorXd states;
    double loss = 0.0;
  };

  static LinkNow AtCurrentPoses(const Link& link);
  Solution Solve() const;
  /// Derivatives of the link's residual by the parameters of its poses.
  static std::array<Matrix6d, 2> ByPoses(const Link& link, const Eigen::VectorXd& states);

  std::vector<Link> links_;
  /// Prior of the states.
  Eigen::VectorXd expected_;
  Eigen::MatrixXd prior_information_;
};

}  // namespace plslam
