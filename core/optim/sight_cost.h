#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <ceres/cost_function.h>

#include "core/motion/robust.h"
#include "core/optim/camera_view.h"

namespace plslam {

/// Largest squared norm of an inlier's whitened residuals; index: rows.
using Gates = std::array<double, 5>;

/// How a sight fits: squared norms of its residuals, whitened and in pixels.
struct Fit {
  double squared = 0.0;
  double squared_px = 0.0;
  bool in_front = false;
};

/// What all sights share.
struct SightContext {
  double huber_delta = 1.0;
  /// The solver is to stop: nothing more is evaluated.
  bool finished = false;
};

/// One sight as Ceres sees it. What it has of a pose comes from the pose's view, which the solver keeps up to date. Sights
/// that do not take part cost nothing; those that a step brings behind the camera cost a constant, so that
/// one bad landmark does not forbid the step.
template <class Cost>
class SightCostFunction final : public ceres::CostFunction {
 public:
  using Landmark = typename Cost::Landmark;

  void Bind(const Cost& cost_in, const SightContext& context, AdjustedPose& pose_in, Landmark& landmark_in,
            int sight_in) {
    cost = cost_in;
    context_ = &context;
    pose = &pose_in;
    landmark = &landmark_in;
    sight = sight_in;
    set_num_residuals(cost.rows());
    if (landmark->free) mutable_parameter_block_sizes()->push_back(Landmark::kSize);
    if (pose->IsFree()) mutable_parameter_block_sizes()->push_back(6);
    Refit();
    at_start = now;
    active = now.in_front;
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double* x = landmark->free ? parameters[0] : landmark->x.data();
    double* by_landmark = jacobians && landmark->free ? jacobians[0] : nullptr;
    double* by_pose = jacobians && pose->IsFree() ? jacobians[landmark->free ? 1 : 0] : nullptr;
    const bool takes_part = active && !context_->finished;
    if (takes_part && Measure(cost.Evaluate(pose->view, x, residuals, by_pose, by_landmark), residuals)) return true;
    std::fill_n(residuals, cost.rows(), 0.0);
    if (takes_part) residuals[0] = kBehind;
    if (by_landmark) std::fill_n(by_landmark, cost.rows() * Landmark::kSize, 0.0);
    if (by_pose) std::fill_n(by_pose, cost.rows() * 6, 0.0);
    return true;
  }

  /// Evaluates the fit at the state as it is.
  void Refit() const {
    double r[Cost::kMaxRows];
    Measure(cost.Evaluate(pose->view, landmark->x.data(), r, nullptr, nullptr), r);
  }

  /// Of the fit as it was evaluated last.
  bool Agrees(const Gates& gates) const { return now.in_front && now.squared <= gates[cost.rows()]; }
  double Loss() const {
    return PseudoHuberLoss(now.in_front ? now.squared : kBehind * kBehind, context_->huber_delta);
  }

  Cost cost;
  AdjustedPose* pose = nullptr;
  Landmark* landmark = nullptr;
  int sight = -1;
  bool active = false;
  Fit at_start;
  mutable Fit now;

 private:
  /// In standard deviations.
  static constexpr double kBehind = 30.0;

  bool Measure(bool in_front, const double* residuals) const {
    now.in_front = in_front;
    if (!in_front) return false;
    now.squared = 0.0;
    for (int i = 0; i < cost.rows(); ++i) now.squared += residuals[i] * residuals[i];
    now.squared_px = cost.SquaredPixels(residuals);
    return true;
  }

  const SightContext* context_ = nullptr;
};

/// Holds a landmark near its start where sights alone do not: at infinity, seen once without disparity, along a line.
/// It is nothing beside what is measured.
template <class Landmark>
class WeakPrior final : public ceres::CostFunction {
 public:
  using Information = Eigen::Matrix<double, Landmark::kSize, Landmark::kSize>;

  /// The deviation is the distance to the landmark; along a line a hundredth of the length.
  WeakPrior(const Landmark& landmark, double distance_m, const SightContext& context)
      : start_(landmark.start), weight_(landmark.PriorWeight(distance_m)), context_(context) {
    set_num_residuals(Landmark::kSize);
    mutable_parameter_block_sizes()->push_back(Landmark::kSize);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    using Parameters = typename Landmark::Parameters;
    const double on = context_.finished ? 0.0 : 1.0;
    Eigen::Map<Parameters>{residuals} = on * weight_ * (Eigen::Map<const Parameters>(parameters[0]) - start_);
    // Symmetric, so rows or columns first are the same.
    if (jacobians && jacobians[0]) Eigen::Map<Information>{jacobians[0]} = on * weight_;
    return true;
  }

  Information information() const { return weight_ * weight_; }

 private:
  typename Landmark::Parameters start_;
  Information weight_;
  const SightContext& context_;
};

}  // namespace plslam
