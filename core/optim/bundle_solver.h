#pragma once

#include <atomic>
#include <functional>
#include <vector>

#include <ceres/ceres.h>

#include "core/optim/camera_view.h"
#include "core/optim/options.h"
#include "core/optim/sight_group.h"

namespace plslam {

/// What the solver asks of the sights.
struct SightActions {
  /// As sights were evaluated last.
  std::function<LossSum()> loss;
  /// Takes outliers away, as sights were evaluated last.
  std::function<void()> trim;
  /// From here on sights are zero: there is nothing more to do.
  std::function<void()> finish;
};

struct BundlePass {
  /// False where Ceres failed; the state is then undefined.
  bool ok = false;
  bool stopped = false;
  int iterations = 0;
};

/// Keeps the views of poses at the parameters that Ceres is about to evaluate, and ends a pass when a step has gained
/// little. (Ceres' own test throws that step away, or evaluates Jacobians that nobody uses.)
///
/// Outliers are trimmed once within a pass, before the Jacobians of its second step are evaluated: a pass of its own would
/// cost as much as a step. Sights can only be taken away there: Ceres compares the next cost with the one before.
class BundleMonitor : public ceres::EvaluationCallback, public ceres::IterationCallback {
 public:
  BundleMonitor(std::vector<AdjustedPose>& poses, const SightActions& sights, const BundleOptions& options,
                const std::atomic<bool>* stop)
      : poses_(poses), sights_(sights), options_(options), stop_(stop) {}

  /// Before each pass.
  void Start(bool trim);

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override;

  int iterations() const { return iterations_; }
  bool stopped() const { return stopped_; }

 private:
  void StepTaken();

  std::vector<AdjustedPose>& poses_;
  const SightActions& sights_;
  const BundleOptions& options_;
  const std::atomic<bool>* stop_;
  double loss_ = 0.0;
  int iterations_ = 0;
  bool trim_ = false;
  bool finished_ = false;
  bool stopped_ = false;
};

/// Options of a problem whose functions are owned by the caller, and known to be right.
ceres::Problem::Options BundleProblemOptions(BundleMonitor& monitor);

/// Levenberg-Marquardt on what is in `problem`, landmarks (group 0 of `order`) eliminated before poses (group 1).
BundlePass SolveBundle(ceres::Problem& problem, const ceres::ParameterBlockOrdering& order, BundleMonitor& monitor,
                       const BundleOptions& options);

}  // namespace plslam
