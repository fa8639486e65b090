// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <numbers>

#include <optional>
#include <string>
#include <vector>

#include "core/config/choices.h"
#include "core/geometry/se3.h"

namespace plslam {

/// Returns the angle in [-pi, pi] that differs from `angle_rad` by whole turns.
inline double WrapAngle(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

/// Rigid transform of the plane; sibling of SE3. Tangent vectors are [translation_m; rotation_rad].
class SE2 {
 public:
  SE2() = default;
  /// The angle is not wrapped.
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

/// Start of the iterations: the poses as given, the chordal relaxation of the rotations with the resulting translations
/// (Carlone et al. 2015), or whichever of the two ends lower.
enum class GraphStart { kGiven, kChordal, kBest };
constexpr auto ChoicesOf(GraphStart) {
  return std::array{Choice{"given", GraphStart::kGiven}, Choice{"chordal", GraphStart::kChordal},
                    Choice{"best", GraphStart::kBest}};
}

/// Pose graph (PL-SLAM §VI.B). The defaults are for closing a loop in a map that is nearly correct.
struct PoseGraphOptions {
  GraphStart start = GraphStart::kGiven;
  /// Levenberg-Marquardt iterations of each solve.
  int max_iterations = 30;
  /// Share of the chi-square that a step must gain for another one to follow.
  double function_tolerance = 1e-5;
  /// A loop edge is rejected if the rest of the graph contradicts it by more than this chi-square (6 degrees of
  /// freedom; 100 allows for drift beyond the covariances).
  double rejection_chi2 = 100.0;
};

/// Degrees of freedom of a pose: 6 in space, 3 in the plane.
template <class Pose>
inline constexpr int kPoseFreedom = 6;
template <>
inline constexpr int kPoseFreedom<SE2> = 3;

template <class Pose>
using PoseMatrix = Eigen::Matrix<double, kPoseFreedom<Pose>, kPoseFreedom<Pose>>;

/// A node of the graph; fixed ones determine the gauge.
template <class Pose>
struct PoseGraphNode {
  Pose T_w_kf;
  bool fixed = false;
};

/// A measured motion between two nodes, with the information (inverse covariance) of its right perturbation.
template <class Pose>
struct PoseGraphMotion {
  /// Indices in `nodes`.
  int a = -1;
  int b = -1;
  Pose T_a_b;
  PoseMatrix<Pose> information = PoseMatrix<Pose>::Identity();
  /// Whether it may be wrong as a whole (a loop) and can be rejected.
  bool robust = false;
};

template <class Pose>
struct PoseGraph {
  std::vector<PoseGraphNode<Pose>> poses;
  std::vector<PoseGraphMotion<Pose>> edges;
};

template <class Pose>
struct PoseGraphSolution {
  /// False if there is nothing to do (no edges, nothing free), the input is invalid (an index out of range, an edge
  /// from a pose to itself, values that are not finite, information that is not positive definite), or the solver
  /// failed; poses are then as given, and `reason` says why. Never NaN.
  bool ok = false;
  std::string reason;
  std::vector<Pose> T_w_kf;
  /// Chi-square of all edges at the given poses, and of the edges that are not rejected at the result.
  double chi2_before = 0.0;
  double chi2_after = 0.0;
  /// Rejected edges, in the order of the edges.
  std::vector<bool> rejected;
  /// Total of all solves.
  int iterations = 0;
};

using PoseGraphPose = PoseGraphNode<SE3>;
using PoseGraphEdge = PoseGraphMotion<SE3>;
using PoseGraphProblem = PoseGraph<SE3>;
using PoseGraphResult = PoseGraphSolution<SE3>;

/// Minimises the edges' sum of e^T information e over the poses (PL-SLAM §VI.B), in space or in the plane. With
/// E = T_a_b^-1 T_w_a^-1 T_w_b, e is [translation; twice the vector part of the unit quaternion with w >= 0] in space
/// and [translation; angle] in the plane: to first order the right perturbation, and exactly the error of g2o's
/// EDGE_SE3:QUAT and EDGE_SE2.
///
/// In each connected part without a fixed pose the first one is constant. One thread; equal input gives equal output.
///
/// Edges with `robust` can be rejected, one by one: the edge that the rest contradicts most (by the chi-square that
/// its removal would gain, from the covariance of its residual) is rejected if that exceeds `rejection_chi2` and a
/// solve without it confirms the gain. This greedily lowers the sum of min(chi2, rejection_chi2), in the sense of data
/// snooping. Edges that agree with each other support each other.
PoseGraphSolution<SE3> OptimisePoseGraph(const PoseGraph<SE3>& graph, const PoseGraphOptions& options);
PoseGraphSolution<SE2> OptimisePoseGraph(const PoseGraph<SE2>& graph, const PoseGraphOptions& options);

/// Returns the covariance of the right perturbation of each pose of a result with `ok`, given the constant poses; zero
/// for these. Computes only the diagonal blocks of the inverse information.
std::vector<PoseMatrix<SE3>> PoseGraphCovariances(const PoseGraph<SE3>& graph,
                                                  const PoseGraphSolution<SE3>& solution);
std::vector<PoseMatrix<SE2>> PoseGraphCovariances(const PoseGraph<SE2>& graph,
                                                  const PoseGraphSolution<SE2>& solution);

/// Returns the sum of e^T information e of all edges.
double PoseGraphChi2(const PoseGraph<SE3>& graph, const std::vector<SE3>& T_w_kf);
double PoseGraphChi2(const PoseGraph<SE2>& graph, const std::vector<SE2>& T_w_kf);

/// Returns nullopt if the covariance is not finite or not positive definite.
std::optional<Matrix6d> InformationFromCovariance(const Matrix6d& covariance);

}  // namespace plslam
