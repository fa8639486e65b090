// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include "core/motion/robust.h"
#include "core/optim/bundle/camera_view.h"

namespace plslam {

/// Largest squared norm of an inlier's whitened residuals, indexed by the number of rows.
using Gates = std::array<double, 5>;

/// Fit of an observation: squared norms of its residuals, whitened and in pixels.
struct Fit {
  double squared = 0.0;
  double squared_px = 0.0;
  bool in_front = false;
};

/// An observation with its pose and landmark, evaluated at their current state; it stores its last fit. If a step moves
/// the landmark behind the camera, the observation costs a constant, so that one bad landmark does not forbid the step,
/// but no less than at the start, so that the step gains nothing by it.
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

  /// Both use the last evaluated fit.
  bool Agrees(const Gates& gates) const { return now.in_front && now.squared <= gates[cost.rows()]; }
  double Loss(double huber_delta) const {
    return PseudoHuberLoss(now.in_front ? now.squared : SquaredBehindCamera(), huber_delta);
  }

  /// Squared residuals assigned to a landmark behind the camera.
  double SquaredBehindCamera() const {
    constexpr double kSigmas = 30.0;
    return std::max(kSigmas * kSigmas, at_start.squared);
  }

  Cost cost;
  AdjustedPose* pose = nullptr;
  const Landmark* landmark = nullptr;
  /// Index in the given list.
  int observation = -1;
  /// Whether it takes part.
  bool active = false;
  Fit at_start;
  mutable Fit now;
};

}  // namespace plslam
