// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <utility>

#include "core/optim/bundle/options.h"

namespace plslam {

struct LossSum {
  double loss = 0.0;
  double rows = 0.0;
};

/// What is asked of the observations after a step, as they were evaluated last.
struct ObservationActions {
  std::function<LossSum()> loss;
  /// Loss of all that is no observation: weak priors and relative poses, at the state as it is.
  std::function<double()> other_loss;
  /// Takes outliers away.
  std::function<void()> trim;
};

struct BundlePass {
  /// False where the solver failed; the state is then undefined.
  bool ok = false;
  bool stopped = false;
  int iterations = 0;
};

/// Ends a pass when a step has gained little of the whole loss.
///
/// Outliers are trimmed once within a pass, as soon as the observations are near enough to tell them and before the
/// next derivatives are evaluated: a pass of its own would cost as much as a step. Observations can only be taken
/// away there: the next cost is compared with the one before.
class StepControl {
 public:
  StepControl(ObservationActions observations, const BundleOptions& options, const std::atomic<bool>* stop)
      : observations_(std::move(observations)), options_(options), stop_(stop) {}

  /// At the state that a pass starts from.
  void Start(bool trim);

  /// A step was accepted. True where another one is worth it.
  bool GoesOn();

  bool IsStopped() const { return stop_ && *stop_; }

 private:
  ObservationActions observations_;
  const BundleOptions& options_;
  const std::atomic<bool>* stop_;
  double loss_ = 0.0;
  double other_loss_ = 0.0;
  bool trim_ = false;
};

}  // namespace plslam
