#include "core/optim/bundle/relative_poses.h"

#include <cmath>

#include "core/motion/robust.h"

namespace plslam {

RelativePoses::RelativePoses(const std::vector<RelativePose>& measured, std::vector<AdjustedPose>& poses) {
  for (const RelativePose& relative : measured) {
    AdjustedPose& a = poses[static_cast<size_t>(relative.a)];
    AdjustedPose& b = poses[static_cast<size_t>(relative.b)];
    if (a.sights == 0 || b.sights == 0) continue;
    const RelativePoseCost cost(relative, a, b);
    if (cost.IsUsable()) costs_.push_back(cost);
  }
}

double RelativePoses::Linearise(PoseSystem& system) const {
  using ByPose = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
  double loss = 0.0;
  Vector6d r;
  ByPose by_a;
  ByPose by_b;
  for (const RelativePoseCost& cost : costs_) {
    cost.Evaluate(r.data(), by_a.data(), by_b.data());
    const double squared = r.squaredNorm();
    loss += PseudoHuberLoss(squared, kDelta);
    const double weight = PseudoHuberWeight(squared, kDelta);
    const int a = cost.a().column;
    const int b = cost.b().column;
    if (a >= 0) {
      system.Diagonal(a).noalias() += weight * by_a.transpose() * by_a;
      system.Gradient(a).noalias() += weight * by_a.transpose() * r;
    }
    if (b >= 0) {
      system.Diagonal(b).noalias() += weight * by_b.transpose() * by_b;
      system.Gradient(b).noalias() += weight * by_b.transpose() * r;
    }
    if (a < 0 || b < 0) continue;
    if (a < b) {
      system.Below(a, b).noalias() += weight * by_b.transpose() * by_a;
    } else {
      system.Below(b, a).noalias() += weight * by_a.transpose() * by_b;
    }
  }
  return loss;
}

void RelativePoses::HoldPoses() {
  for (const RelativePoseCost& cost : costs_) cost.a().held = cost.b().held = true;
}

double RelativePoses::Loss() const {
  double loss = 0.0;
  Vector6d r;
  for (const RelativePoseCost& cost : costs_) {
    cost.Evaluate(r.data(), nullptr, nullptr);
    loss += PseudoHuberLoss(r.squaredNorm(), kDelta);
  }
  return loss;
}

}  // namespace plslam
