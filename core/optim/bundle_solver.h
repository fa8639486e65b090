#pragma once

#include <atomic>
#include <vector>

#include <ceres/ceres.h>

#include "core/optim/camera_view.h"
#include "core/optim/options.h"

namespace plslam {

/// One pass of the adjustment in Ceres: Levenberg-Marquardt on what is in `problem`, landmarks (group 0 of `order`)
/// eliminated before poses (group 1).
struct BundlePass {
  /// False where Ceres failed; the state is then undefined.
  bool ok = false;
  bool stopped = false;
  int iterations = 0;
};

/// Keeps the views of all poses at the parameters that Ceres is about to evaluate.
class ViewUpdater : public ceres::EvaluationCallback {
 public:
  explicit ViewUpdater(std::vector<AdjustedPose>& poses) : poses_(poses) {}
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

 private:
  std::vector<AdjustedPose>& poses_;
};

/// Options of a problem whose functions are owned by the caller, and known to be right.
ceres::Problem::Options BundleProblemOptions(ViewUpdater& views);

BundlePass SolveBundle(ceres::Problem& problem, const ceres::ParameterBlockOrdering& order,
                       const BundleOptions& options, const std::atomic<bool>* stop);

}  // namespace plslam
