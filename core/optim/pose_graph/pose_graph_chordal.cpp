// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph_chordal.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>

#include "core/optim/pose_graph/pose_graph_blocks.h"
#include "core/optim/pose_graph/pose_graph_group.h"

namespace plslam {
namespace {

template <class Pose>
constexpr int kD = PoseGroup<Pose>::kDimension;
template <class Pose>
using Rotation = Eigen::Matrix<double, kD<Pose>, kD<Pose>>;
using Solver = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;

std::optional<Eigen::MatrixXd> Solve(const Eigen::SparseMatrix<double>& H, const Eigen::MatrixXd& rhs) {
  const Solver solver(H);
  if (solver.info() != Eigen::Success) return std::nullopt;
  Eigen::MatrixXd x = solver.solve(rhs);
  if (!x.allFinite()) return std::nullopt;
  return x;
}

/// Scalar information of the rotation: the inverse of the mean variance.
template <class Pose>
double RotationWeight(const PoseMatrix<Pose>& information) {
  constexpr int kTurns = kPoseFreedom<Pose> - kD<Pose>;
  const Eigen::Matrix<double, kTurns, kTurns> turn = information.template bottomRightCorner<kTurns, kTurns>();
  return kTurns / turn.llt().solve(Eigen::Matrix<double, kTurns, kTurns>::Identity()).trace();
}

template <class Pose>
Rotation<Pose> NearestRotation(const Rotation<Pose>& M) {
  const Eigen::JacobiSVD<Rotation<Pose>> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Rotation<Pose> sign = Rotation<Pose>::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) sign(kD<Pose> - 1, kD<Pose> - 1) = -1.0;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

/// Transposed rotations of the free poses, stacked: R_w_b^T = R_a_b^T R_w_a^T in the least-squares sense.
template <class Pose>
std::optional<Eigen::MatrixXd> RelaxedRotations(const PoseGraph<Pose>& graph, const std::vector<bool>& constant) {
  PoseBlockMatrix<kD<Pose>> H(constant);
  Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(H.rows(), kD<Pose>);
  for (const PoseGraphMotion<Pose>& edge : graph.edges) {
    const double weight = RotationWeight<Pose>(edge.information);
    const Rotation<Pose> coupling = weight * edge.T_a_b.R();
    H.Add(edge.a, edge.a, weight * Rotation<Pose>::Identity());
    H.Add(edge.b, edge.b, weight * Rotation<Pose>::Identity());
    H.Add(edge.a, edge.b, -coupling);
    const int a = H.column(edge.a);
    const int b = H.column(edge.b);
    if (a >= 0 && b < 0) {
      rhs.template middleRows<kD<Pose>>(kD<Pose> * a) += coupling * graph.poses[edge.b].T_w_kf.R().transpose();
    }
    if (b >= 0 && a < 0) {
      rhs.template middleRows<kD<Pose>>(kD<Pose> * b) += (graph.poses[edge.a].T_w_kf.R() * coupling).transpose();
    }
  }
  return Solve(H.Build(), rhs);
}

/// Takes one Gauss-Newton step of the translations alone, in which the error is linear.
template <class Pose>
bool SetTranslations(const PoseGraph<Pose>& graph, const std::vector<bool>& constant, std::vector<Pose>& poses) {
  PoseBlockMatrix<kD<Pose>> H(constant);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(H.rows());
  const auto add_to = [&](int pose, const Eigen::Matrix<double, kD<Pose>, 1>& v) {
    if (H.column(pose) >= 0) rhs.template segment<kD<Pose>>(kD<Pose> * H.column(pose)) += v;
  };
  for (const PoseGraphMotion<Pose>& edge : graph.edges) {
    const PoseEdgeError<Pose> error = PoseGroup<Pose>::Error(edge.T_a_b, poses[edge.a], poses[edge.b]);
    const auto by_a = error.by_a.template leftCols<kD<Pose>>();
    const auto by_b = error.by_b.template leftCols<kD<Pose>>();
    H.Add(edge.a, edge.a, by_a.transpose() * edge.information * by_a);
    H.Add(edge.b, edge.b, by_b.transpose() * edge.information * by_b);
    H.Add(edge.a, edge.b, by_a.transpose() * edge.information * by_b);
    add_to(edge.a, -by_a.transpose() * edge.information * error.e);
    add_to(edge.b, -by_b.transpose() * edge.information * error.e);
  }
  const auto moves = Solve(H.Build(), rhs);
  if (!moves) return false;
  for (size_t i = 0; i < poses.size(); ++i) {
    const int column = H.column(static_cast<int>(i));
    if (column < 0) continue;
    Eigen::Matrix<double, kPoseFreedom<Pose>, 1> step = Eigen::Matrix<double, kPoseFreedom<Pose>, 1>::Zero();
    step.template head<kD<Pose>>() = moves->template block<kD<Pose>, 1>(kD<Pose> * column, 0);
    poses[i] = PoseGroup<Pose>::Plus(poses[i], step.data());
  }
  return true;
}

}  // namespace

template <class Pose>
std::optional<std::vector<Pose>> ChordalPoses(const PoseGraph<Pose>& graph, const std::vector<bool>& constant) {
  const auto relaxed = RelaxedRotations(graph, constant);
  if (!relaxed) return std::nullopt;
  std::vector<Pose> poses;
  int column = 0;
  for (size_t i = 0; i < constant.size(); ++i) {
    const Pose& given = graph.poses[i].T_w_kf;
    if (constant[i]) {
      poses.push_back(given);
      continue;
    }
    const Rotation<Pose> R = relaxed->template middleRows<kD<Pose>>(kD<Pose> * column++).transpose();
    poses.push_back(PoseGroup<Pose>::FromRotation(NearestRotation<Pose>(R), given.translation()));
  }
  if (!SetTranslations(graph, constant, poses)) return std::nullopt;
  return poses;
}

template std::optional<std::vector<SE3>> ChordalPoses(const PoseGraph<SE3>&, const std::vector<bool>&);
template std::optional<std::vector<SE2>> ChordalPoses(const PoseGraph<SE2>&, const std::vector<bool>&);

}  // namespace plslam
