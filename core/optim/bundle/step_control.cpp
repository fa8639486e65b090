// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/step_control.h"

#include <utility>

namespace plslam {
namespace {

// Outliers can be identified once a step gains less than this share of the loss, or the loss for each row is below the
// second; inliers alone leave 0.6.
constexpr double kNearGain = 0.5;
constexpr double kNearLoss = 1.5;

}  // namespace

void StepControl::Start(bool trim) {
  trim_ = trim;
  loss_ = observations_.loss().loss;
  other_loss_ = observations_.other_loss();
}

bool StepControl::ShouldContinue() {
  const LossSum now = observations_.loss();
  const double before = std::exchange(loss_, now.loss);
  const double gain = before - now.loss;
  const double other = observations_.other_loss();
  const double other_before = std::exchange(other_loss_, other);
  if (trim_ && (gain <= kNearGain * before || now.loss <= kNearLoss * now.rows)) {
    trim_ = false;
    observations_.trim();
    loss_ = observations_.loss().loss;
    return true;
  }
  return gain + other_before - other > options_.function_tolerance * (before + other_before);
}

}  // namespace plslam
