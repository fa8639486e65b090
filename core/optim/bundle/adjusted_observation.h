// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include "core/motion/robust.h"
#include "core/optim/bundle/camera_view.h"

namespace plslam {

/// Largest squared norm of an inlier's whitened residuals; index: rows.
using Gates = std::array<double, 5>;

/// How an observation fits: squared norms of its residuals, whitened and in pixels.
struct Fit {
  double squared = 0.0;
  double squared_px = 0.0;
  bool in_front = false;
};

/// An observation with the pose and the landmark that it ties together; it is evaluated at their state as it is, and
/// remembers how it fitted. One that a step brings behind the camera costs a constant, so that one bad landmark does
/// not forbid the step, and no less than at the start, so that nothing is gained by it.
template <class Cost>
class AdjustedObservation {
 public:
  using Landmark = typename Cost::Landmark;

  void Bind(const Cost& cost_in, AdjustedPose& pose_in, const Landmark& landmark_in, int observation_in) {
    cost = cost_in;
    pose = &pose_in;
    landmark = &landmark_in;
    observation = observation_in;
    Refit();
    at_start = now;
    active = now.in_front;
  }

  /// As `Cost::Evaluate`.
  bool Evaluate(double* residuals, double* by_pose, double* by_landmark) const {
    now.in_front = cost.Evaluate(pose->view, landmark->x.data(), residuals, by_pose, by_landmark);
    if (!now.in_front) return false;
    now.squared = 0.0;
    for (int i = 0; i < cost.rows(); ++i) now.squared += residuals[i] * residuals[i];
    now.squared_px = cost.SquaredPixels(residuals);
    return true;
  }

  void Refit() const {
    double r[Cost::kMaxRows];
    Evaluate(r, nullptr, nullptr);
  }

  /// Of the fit as it was evaluated last.
  bool Agrees(const Gates& gates) const { return now.in_front && now.squared <= gates[cost.rows()]; }
  double Loss(double huber_delta) const {
    return PseudoHuberLoss(now.in_front ? now.squared : SquaredBehind(), huber_delta);
  }

  /// What stands for the squared residuals behind the camera.
  double SquaredBehind() const {
    constexpr double kSigmas = 30.0;
    return std::max(kSigmas * kSigmas, at_start.squared);
  }

  Cost cost;
  AdjustedPose* pose = nullptr;
  const Landmark* landmark = nullptr;
  /// Place in the list given.
  int observation = -1;
  /// Takes part.
  bool active = false;
  Fit at_start;
  mutable Fit now;
};

}  // namespace plslam
