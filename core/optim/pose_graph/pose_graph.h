// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/se3.h"

namespace plslam {

/// Angle in [-pi, pi] that differs from `angle_rad` by whole turns.
inline double WrapAngle(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

/// Rigid transform of the plane; what SE3 is in space. Tangent vectors are [translation_m; rotation_rad].
class SE2 {
 public:
  SE2() = default;
  /// The angle is kept as it is.
  SE2(double angle_rad, const Eigen::Vector2d& t) : angle_(angle_rad), t_(t) {}

  double angle() const { return angle_; }
  const Eigen::Vector2d& translation() const { return t_; }
  Eigen::Matrix2d R() const {
    const double c = std::cos(angle_);
    const double s = std::sin(angle_);
    Eigen::Matrix2d m;
    m << c, -s, s, c;
    return m;
  }

  SE2 Inverse() const { return SE2(-angle_, -(R().transpose() * t_)); }
  SE2 operator*(const SE2& other) const { return SE2(WrapAngle(angle_ + other.angle_), t_ + R() * other.t_); }
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const { return R() * p + t_; }

  /// No NaN, no infinity.
  bool IsFinite() const { return std::isfinite(angle_) && t_.allFinite(); }

 private:
  double angle_ = 0.0;
  Eigen::Vector2d t_ = Eigen::Vector2d::Zero();
};

/// Pose graph (PL-SLAM §VI.B). The defaults are for closing a loop from a map that is nearly right.
struct PoseGraphOptions {
  /// Where iterations begin: at the poses as given, at the chordal relaxation of the rotations with the translations
  /// that follow (Carlone et al. 2015), or from whichever of the two ends lower.
  std::string start = "given";
  /// Levenberg-Marquardt iterations of each solve.
  int max_iterations = 30;
  /// Share of the cost that a step must gain for another one to follow.
  double function_tolerance = 1e-5;
  /// A loop edge is taken out where the rest of the graph contradicts it by more than this chi-square (6 degrees of
  /// freedom; 100 allows for drift beyond what covariances say).
  double rejection_chi2 = 100.0;
};

/// Degrees of freedom of a pose: 6 in space, 3 in the plane.
template <class Pose>
inline constexpr int kPoseFreedom = 6;
template <>
inline constexpr int kPoseFreedom<SE2> = 3;

template <class Pose>
using PoseMatrix = Eigen::Matrix<double, kPoseFreedom<Pose>, kPoseFreedom<Pose>>;

/// A node of the graph; fixed ones hold the others in place.
template <class Pose>
struct PoseGraphNode {
  Pose T_w_kf;
  bool fixed = false;
};

/// What is known of the motion between two nodes, with the information (inverse covariance) of its right
/// perturbation.
template <class Pose>
struct PoseGraphMotion {
  /// Places in `nodes`.
  int a = -1;
  int b = -1;
  Pose T_a_b;
  PoseMatrix<Pose> information = PoseMatrix<Pose>::Identity();
  /// May be wrong as a whole (a loop); the others are believed.
  bool robust = false;
};

template <class Pose>
struct PoseGraph {
  std::vector<PoseGraphNode<Pose>> poses;
  std::vector<PoseGraphMotion<Pose>> edges;
};

template <class Pose>
struct PoseGraphSolution {
  /// False where there is nothing to do (no edges, nothing free) or the input is refused (an index out of range, an
  /// edge from a pose to itself, values that are not finite, information that is not positive definite) or the solver
  /// failed; poses are then as given, and `reason` says why. Never a NaN.
  bool ok = false;
  std::string reason;
  std::vector<Pose> T_w_kf;
  /// Over all edges at the poses as given; over the edges that were not rejected at the end.
  double chi2_before = 0.0;
  double chi2_after = 0.0;
  /// In the order of the edges.
  std::vector<bool> rejected;
  /// Of all solves together.
  int iterations = 0;
};

using PoseGraphPose = PoseGraphNode<SE3>;
using PoseGraphEdge = PoseGraphMotion<SE3>;
using PoseGraphProblem = PoseGraph<SE3>;
using PoseGraphResult = PoseGraphSolution<SE3>;

/// Moves the poses so that the edges' sum of e^T information e is least (PL-SLAM §VI.B), in space or in the plane.
/// With E = T_a_b^-1 T_w_a^-1 T_w_b, e is [translation; twice the vector part of the unit quaternion with w >= 0] in
/// space and [translation; angle] in the plane: to first order the right perturbation, and exactly the error of g2o's
/// EDGE_SE3:QUAT and EDGE_SE2.
///
/// In each connected part without a fixed pose the first one is constant. One thread; equal input gives equal output.
///
/// Edges that are `robust` can be rejected, whole: one by one, the edge that the rest contradicts most (the
/// chi-square by which its removal would lower the sum, from its residual's covariance) is taken out if that is more
/// than `rejection_chi2` and a solve without it confirms it: the least sum of min(chi2, rejection_chi2), in the sense
/// of data snooping. Edges that agree with each other support each other.
PoseGraphSolution<SE3> OptimisePoseGraph(const PoseGraph<SE3>& graph, const PoseGraphOptions& options);
PoseGraphSolution<SE2> OptimisePoseGraph(const PoseGraph<SE2>& graph, const PoseGraphOptions& options);

/// Covariance of the right perturbation of each pose of a result that is ok, given the poses constant; zero for
/// these. The blocks of the inverse information that are asked for, without the rest of it.
std::vector<PoseMatrix<SE3>> PoseGraphCovariances(const PoseGraph<SE3>& graph,
                                                  const PoseGraphSolution<SE3>& solution);
std::vector<PoseMatrix<SE2>> PoseGraphCovariances(const PoseGraph<SE2>& graph,
                                                  const PoseGraphSolution<SE2>& solution);

/// Sum of e^T information e of all edges.
double PoseGraphChi2(const PoseGraph<SE3>& graph, const std::vector<SE3>& T_w_kf);
double PoseGraphChi2(const PoseGraph<SE2>& graph, const std::vector<SE2>& T_w_kf);

/// nullopt where the covariance is not finite or not positive definite.
std::optional<Matrix6d> InformationFromCovariance(const Matrix6d& covariance);

}  // namespace plslam
