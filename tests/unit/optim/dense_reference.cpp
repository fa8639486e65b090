// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/optim/dense_reference.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/motion/robust.h"
#include "core/optim/bundle/line_cost.h"
#include "core/optim/bundle/point_cost.h"

namespace plslam::test {
namespace {

struct DenseState {
  std::vector<SE3> T_w_c;
  std::vector<AdjustedPoint> points;
  std::vector<AdjustedLine> lines;
};

class DenseProblem {
 public:
  DenseProblem(const BundleProblem& problem, double delta) : problem_(problem), delta_(delta) {
    for (const BundlePose& pose : problem.poses) state.T_w_c.push_back(pose.T_w_c);
    for (const BundlePoint& point : problem.points) state.points.emplace_back(point);
    for (const BundleLine& line : problem.lines) state.lines.emplace_back(line);
    for (const BundlePose& pose : problem.poses) size_ += pose.fixed ? 0 : 6;
    for (const BundlePoint& point : problem.points) size_ += point.fixed ? 0 : 3;
    for (const BundleLine& line : problem.lines) size_ += line.fixed ? 0 : 4;
    for (const LineObservation& observation : problem.line_observations) {
      const AdjustedPose pose(state.T_w_c[observation.pose], -1);
      line_costs_.emplace_back(observation, state.lines[observation.line], pose.view, problem.camera);
    }
  }

  int size() const { return size_; }

  DenseState Moved(const Eigen::VectorXd& x) const {
    DenseState moved = state;
    int at = 0;
    for (size_t i = 0; i < moved.T_w_c.size(); ++i) {
      if (problem_.poses[i].fixed) continue;
      moved.T_w_c[i] = moved.T_w_c[i] * SE3::Exp(x.segment<6>(at));
      at += 6;
    }
    for (AdjustedPoint& point : moved.points) {
      if (!point.free) continue;
      point.x += x.segment<3>(at);
      at += 3;
    }
    for (AdjustedLine& line : moved.lines) {
      if (!line.free) continue;
      line.x += x.segment<4>(at);
      at += 4;
    }
    return moved;
  }

  // Whitened residuals, one vector per observation.
  std::vector<Eigen::VectorXd> Residuals(const DenseState& s) const {
    std::vector<Eigen::VectorXd> residuals;
    for (const PointObservation& observation : problem_.point_observations) {
      const AdjustedPose pose(s.T_w_c[observation.pose], -1);
      const PointCost cost(observation, s.points[observation.point], pose.view, problem_.camera);
      Eigen::VectorXd r(cost.rows());
      cost.Evaluate(pose.view, s.points[observation.point].x.data(), r.data(), nullptr, nullptr);
      residuals.push_back(r);
    }
    for (size_t i = 0; i < problem_.line_observations.size(); ++i) {
      const LineObservation& observation = problem_.line_observations[i];
      const AdjustedPose pose(s.T_w_c[observation.pose], -1);
      Eigen::VectorXd r(line_costs_[i].rows());
      line_costs_[i].Evaluate(pose.view, s.lines[observation.line].x.data(), r.data(), nullptr, nullptr);
      residuals.push_back(r);
    }
    return residuals;
  }

  double Cost(const DenseState& s) const {
    double sum = 0.0;
    for (const Eigen::VectorXd& r : Residuals(s)) sum += 0.5 * PseudoHuberLoss(r.squaredNorm(), delta_);
    return sum;
  }

  void Linearize(Eigen::MatrixXd& H, Eigen::VectorXd& g) const {
    constexpr double kStep = 1e-6;
    const std::vector<Eigen::VectorXd> at = Residuals(state);
    std::vector<Eigen::MatrixXd> J;
    for (const Eigen::VectorXd& r : at) J.emplace_back(r.size(), size_);
    for (int k = 0; k < size_; ++k) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(size_, k);
      const auto plus = Residuals(Moved(step));
      const auto minus = Residuals(Moved(-step));
      for (size_t i = 0; i < at.size(); ++i) J[i].col(k) = (plus[i] - minus[i]) / (2.0 * kStep);
    }
    H = Eigen::MatrixXd::Zero(size_, size_);
    g = Eigen::VectorXd::Zero(size_);
    for (size_t i = 0; i < at.size(); ++i) {
      const double weight = PseudoHuberWeight(at[i].squaredNorm(), delta_);
      H += weight * J[i].transpose() * J[i];
      g += weight * J[i].transpose() * at[i];
    }
  }

  DenseState state;

 private:
  const BundleProblem& problem_;
  double delta_;
  int size_ = 0;
  // Anchored at the start.
  std::vector<LineCost> line_costs_;
};

}  // namespace

DenseResult AdjustDense(const BundleProblem& given, double huber_delta) {
  DenseProblem problem(given, huber_delta);
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double damping = 1e-6;
  double cost = problem.Cost(problem.state);
  for (int i = 0; i < 100; ++i) {
    problem.Linearize(H, g);
    Eigen::MatrixXd damped = H;
    damped.diagonal() *= 1.0 + damping;
    const Eigen::VectorXd step = -damped.ldlt().solve(g);
    const DenseState moved = problem.Moved(step);
    const double moved_cost = problem.Cost(moved);
    if (moved_cost < cost) {
      problem.state = moved;
      cost = moved_cost;
      damping = std::max(1e-9, damping / 10.0);
    } else {
      damping *= 10.0;
    }
    if (step.norm() < 1e-10 || damping > 1e6) break;
  }
  problem.Linearize(H, g);
  DenseResult result;
  result.T_w_c = problem.state.T_w_c;
  for (const AdjustedPoint& point : problem.state.points) result.points.push_back(point.x);
  for (const AdjustedLine& line : problem.state.lines) result.lines.push_back(line.Segment());
  result.cost = cost;
  result.covariance = H.inverse();
  return result;
}

}  // namespace plslam::test
