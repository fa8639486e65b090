// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <utility>

#include "core/optim/bundle/options.h"

namespace plslam {

struct LossSum {
  double loss = 0.0;
  double rows = 0.0;  ///< residual rows of the active observations
};

/// Callbacks that evaluate the losses and trim outliers, at the residuals of the last step.
struct ObservationActions {
  std::function<LossSum()> loss;
  /// Loss of weak priors and relative poses at the current state.
  std::function<double()> other_loss;
  /// Deactivates outliers.
  std::function<void()> trim;
};

struct BundlePass {
  /// False if the solver failed; the state is then undefined.
  bool ok = false;
  bool stopped = false;
  int iterations = 0;
};

/// Ends a pass when a step has reduced the loss by little.
///
/// Outliers are trimmed once within a pass, as soon as the residuals are small enough to identify them, and before the
/// next linearisation: a separate pass would cost as much as a step. Trimming only deactivates observations, because
/// the next loss is compared with the previous one.
class StepControl {
 public:
  StepControl(ObservationActions observations, const BundleOptions& options, const std::atomic<bool>* stop)
      : observations_(std::move(observations)), options_(options), stop_(stop) {}

  /// Called at the start state of a pass.
  void Start(bool trim);

  /// Called after an accepted step. Returns whether another one is worthwhile.
  bool ShouldContinue();

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
