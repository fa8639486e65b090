// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/reference/reference_window.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

#include "core/optim/bundle/line_cost.h"
#include "core/optim/reference/line_endpoint_functor.h"
#include "core/optim/reference/line_functor.h"
#include "core/optim/reference/motion_functor.h"
#include "core/optim/reference/point_functor.h"

namespace plslam::test {

ReferenceWindow::ReferenceWindow(const BundleProblem& given, bool endpoints, double huber_delta)
    : given_(given), loss_(huber_delta), poses_(given.poses.size(), Vector6d::Zero()) {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_ = std::make_unique<ceres::Problem>(options);
  for (const BundlePoint& point : given.points) points_.push_back(point.p_w);
  for (const BundleLine& line : given.lines) {
    lines_.emplace_back(Vector6d::Zero());
    if (endpoints) lines_.back() << line.segment_w.p, line.segment_w.q;
  }
  AddPoints();
  endpoints ? AddEndpoints() : AddLines();
  AddMotions();
  for (size_t i = 0; i < given.poses.size(); ++i) {
    if (given.poses[i].fixed) problem_->SetParameterBlockConstant(poses_[i].data());
  }
}

double ReferenceWindow::Solve() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-14;
  return Solve(options).final_cost;
}

ceres::Solver::Summary ReferenceWindow::Solve(ceres::Solver::Options options) {
  options.logging_type = ceres::SILENT;
  options.linear_solver_ordering = Ordering();
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem_.get(), &summary);
  return summary;
}

SE3 ReferenceWindow::T_w_c(size_t i) const { return reference::MovedPose(given_.poses[i].T_w_c, poses_[i].data()); }

double ReferenceWindow::CostAt(const BundleResult& result, bool endpoints) {
  for (size_t i = 0; i < poses_.size(); ++i) {
    const SE3& start = given_.poses[i].T_w_c;
    poses_[i] << result.T_w_c[i].translation() - start.translation(),
        SE3(start.rotation().conjugate() * result.T_w_c[i].rotation(), Eigen::Vector3d::Zero()).Log().tail<3>();
  }
  points_ = result.points;
  for (size_t i = 0; i < lines_.size(); ++i) {
    const Segment3& from = given_.lines[i].segment_w;
    const Segment3& to = result.lines[i];
    if (endpoints) {
      lines_[i] << to.p, to.q;
    } else {
      const Across across = DirectionsAcross(from);
      lines_[i].head<4>() << across.transpose() * (to.p - from.p), across.transpose() * (to.q - from.q);
    }
  }
  double cost = 0.0;
  problem_->Evaluate({}, &cost, nullptr, nullptr, nullptr);
  return cost;
}

std::shared_ptr<ceres::ParameterBlockOrdering> ReferenceWindow::Ordering() {
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  const auto add = [&](double* block, int group) {
    if (problem_->HasParameterBlock(block)) ordering->AddElementToGroup(block, group);
  };
  for (Eigen::Vector3d& point : points_) add(point.data(), 0);
  for (Vector6d& line : lines_) add(line.data(), 0);
  for (Vector6d& pose : poses_) add(pose.data(), 1);
  return ordering;
}

template <class Functor, int kSize>
ceres::CostFunction* ReferenceWindow::Add(const Functor& functor, int pose, double* landmark) {
  using Auto = ceres::AutoDiffCostFunction<Functor, ceres::DYNAMIC, 6, kSize>;
  auto* cost = new Auto(new Functor(functor), functor.rows());
  problem_->AddResidualBlock(cost, &loss_, Pose(pose), landmark);
  return cost;
}

template <class Functor, int kSize>
void ReferenceWindow::Add(const Functor& functor, int pose, double* landmark, const Eigen::Vector3d& middle_w,
                          Knowledge<kSize>& knowledge) {
  const ceres::CostFunction* cost = Add<Functor, kSize>(functor, pose, landmark);
  Eigen::VectorXd r(functor.rows());
  Eigen::Matrix<double, Eigen::Dynamic, kSize, Eigen::RowMajor> J(functor.rows(), kSize);
  const double* blocks[] = {Pose(pose), landmark};
  double* jacobians[] = {nullptr, J.data()};
  if (cost->Evaluate(blocks, r.data(), jacobians)) knowledge.information += J.transpose() * J;
  knowledge.nearest_m = std::min(knowledge.nearest_m, (Start(pose).translation() - middle_w).norm());
}

template <int kSize>
void ReferenceWindow::AddPrior(double* landmark, const Knowledge<kSize>& known) {
  if (!problem_->HasParameterBlock(landmark)) return;
  const double largest_m = 0.3 * known.nearest_m;
  const auto least = known.information.template selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
  if (least > 1.0 / (largest_m * largest_m)) return;
  using Prior = reference::PriorFunctor<kSize>;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  auto* prior = new Prior{Vector(landmark), Eigen::Matrix<double, kSize, kSize>::Identity() / known.nearest_m};
  problem_->AddResidualBlock(new ceres::AutoDiffCostFunction<Prior, kSize, kSize>(prior), nullptr, landmark);
}

void ReferenceWindow::AddPoints() {
  std::vector<Knowledge<3>> known(points_.size());
  for (const PointObservation& seen : given_.point_observations) {
    const auto k = static_cast<size_t>(seen.point);
    const reference::PointFunctor functor{seen, Start(seen.pose), given_.camera};
    Add(functor, seen.pose, points_[k].data(), points_[k], known[k]);
  }
  for (size_t k = 0; k < known.size(); ++k) AddPrior(points_[k].data(), known[k]);
}

void ReferenceWindow::AddLines() {
  std::vector<Knowledge<4>> known(lines_.size());
  for (const LineObservation& seen : given_.line_observations) {
    const auto k = static_cast<size_t>(seen.line);
    const Segment3& segment = given_.lines[k].segment_w;
    const reference::LineFunctor functor(seen, {segment, DirectionsAcross(segment)}, Start(seen.pose), given_.camera);
    Add(functor, seen.pose, lines_[k].data(), Eigen::Vector3d(0.5 * (segment.p + segment.q)), known[k]);
  }
  for (size_t k = 0; k < known.size(); ++k) AddPrior(lines_[k].data(), known[k]);
}

void ReferenceWindow::AddEndpoints() {
  std::vector<double> nearest(given_.lines.size(), 1e9);
  for (const LineObservation& seen : given_.line_observations) {
    const auto k = static_cast<size_t>(seen.line);
    const Segment3& segment = given_.lines[k].segment_w;
    const reference::LineEndpointFunctor functor(seen, segment, Start(seen.pose), given_.camera);
    Add<reference::LineEndpointFunctor, 6>(functor, seen.pose, lines_[k].data());
    const double distance_m = (Start(seen.pose).translation() - 0.5 * (segment.p + segment.q)).norm();
    nearest[k] = std::min(nearest[k], distance_m);
  }
  using Prior = reference::PriorFunctor<6>;
  for (size_t k = 0; k < lines_.size(); ++k) {
    const Segment3& segment = given_.lines[k].segment_w;
    const Eigen::Vector3d step = segment.q - segment.p;
    const Eigen::Matrix3d along = step * step.transpose() / step.squaredNorm();
    const Eigen::Matrix3d W = (Eigen::Matrix3d::Identity() - along) / nearest[k] + along / (0.01 * step.norm());
    auto* prior = new Prior{lines_[k], Matrix6d::Zero()};
    prior->W.topLeftCorner<3, 3>() = W;
    prior->W.bottomRightCorner<3, 3>() = W;
    problem_->AddResidualBlock(new ceres::AutoDiffCostFunction<Prior, 6, 6>(prior), nullptr, lines_[k].data());
  }
}

void ReferenceWindow::AddMotions() {
  for (const RelativePose& motion : given_.relative_poses) {
    using Cost = reference::MotionFunctor;
    auto* cost = new ceres::AutoDiffCostFunction<Cost, 6, 6, 6>(new Cost(motion, Start(motion.a), Start(motion.b)));
    problem_->AddResidualBlock(cost, &motion_loss_, Pose(motion.a), Pose(motion.b));
  }
}

}  // namespace plslam::test
