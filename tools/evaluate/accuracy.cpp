// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/accuracy/roll.h"

namespace plslam::evaluate {
namespace {

std::vector<double> Degrees(std::vector<double> radians) {
  for (double& angle : radians) angle *= 180.0 / M_PI;
  return radians;
}

std::vector<SE3> TruthOf(const PosePairs& pairs) {
  std::vector<SE3> truth;
  truth.reserve(pairs.size());
  for (const PosePair& pair : pairs) truth.push_back(pair.truth);
  return truth;
}

PosePairs Associate(const Trajectory& estimate, const Trajectory& truth, const EvaluateOptions& options) {
  if (options.interpolate_truth) return AssociateInterpolated(estimate, truth, options.max_gap_ns);
  return AssociateNearest(estimate, truth, options.max_difference_ns);
}

std::string Note(const Accuracy& accuracy, const EvaluateOptions& options) {
  if (accuracy.estimated_poses == 0) return "the estimate has no pose";
  if (accuracy.true_poses == 0) return "the truth has no pose";
  if (accuracy.pairs.empty() && options.interpolate_truth) {
    return fmt::format("no pose of the estimate is between two true poses at most {:g} s apart",
                       1e-9 * static_cast<double>(options.max_gap_ns));
  }
  if (accuracy.pairs.empty()) {
    return fmt::format("no pose of the estimate is within {:g} s of a true one",
                       1e-9 * static_cast<double>(options.max_difference_ns));
  }
  if (!std::isfinite(accuracy.ate_m.rmse)) {
    return "positions are too far apart to compute an error: are both in metres and from the same run?";
  }
  if (accuracy.pairs.size() == 1) return "only one pose: no motion can be evaluated";
  if (accuracy.true_path_m == 0.0) return "the true path has length 0: no error per metre can be computed";
  return "";
}

double TrueSpread_m(const PosePairs& pairs) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) mean += pair.truth.translation() / static_cast<double>(pairs.size());
  double sum_m2 = 0.0;
  for (const PosePair& pair : pairs) sum_m2 += (pair.truth.translation() - mean).squaredNorm();
  return pairs.empty() ? 0.0 : std::sqrt(sum_m2 / static_cast<double>(pairs.size()));
}

double Coverage(const Accuracy& accuracy, int64_t n_frames) {
  const bool counted = n_frames > 0;
  const double of = counted ? static_cast<double>(n_frames) : accuracy.true_poses;
  const double found = counted ? accuracy.estimated_poses : static_cast<double>(accuracy.pairs.size());
  return of > 0.0 ? std::min(100.0, 100.0 * found / of) : 0.0;
}

void AddOptionalMeasures(const EvaluateOptions& options, Accuracy& accuracy) {
  if (!options.keyframe_t_ns.empty()) {
    accuracy.keyframes = ComputeKeyframeErrors(accuracy.pairs, options.keyframe_t_ns);
  }
  if (!options.covariances.empty()) {
    accuracy.pose_consistency = PoseConsistency(accuracy.pairs, options.covariances);
  }
  if (!options.motion_covariances.empty()) {
    accuracy.motion_consistency = MotionConsistency(accuracy.pairs, options.motion_covariances);
    accuracy.span_consistency = MotionConsistency(accuracy.pairs, options.motion_covariances, kConsistencySpan);
  }
}

}  // namespace

Accuracy EvaluateTrajectory(const Trajectory& estimate, const Trajectory& truth, const EvaluateOptions& options) {
  Accuracy a;
  a.estimated_poses = static_cast<int>(estimate.size());
  a.true_poses = static_cast<int>(truth.size());
  a.pairs = Associate(estimate, truth, options);
  a.coverage_percent = Coverage(a, options.n_frames);
  if (!a.pairs.empty()) {
    a.true_path_m = TruePath_m(a.pairs).back();
    a.true_spread_m = TrueSpread_m(a.pairs);
    a.duration_s = 1e-9 * static_cast<double>(a.pairs.back().t_ns - a.pairs.front().t_ns);
  }
  a.alignment_kind = options.alignment;
  a.alignment = Align(a.pairs, options.alignment);
  a.absolute = ComputeAbsoluteErrors(a.pairs, a.alignment, AlignOrientations(a.pairs, options.alignment));
  a.ate_m = Summarise(a.absolute.translation_m);
  if (IsLeastSquares(options.alignment))
    a.roll_sigma_deg = RollSigma_rad(TruthOf(a.pairs), a.ate_m.rmse) * 180.0 / M_PI;
  a.ate_deg = Summarise(Degrees(a.absolute.rotation_rad));
  for (const Delta& delta : options.deltas) {
    const RelativeErrors errors = ComputeRelativeErrors(a.pairs, delta);
    a.relative.push_back({delta, Summarise(errors.translation_m), Summarise(Degrees(errors.rotation_rad))});
  }
  a.kitti = ComputeKittiErrors(a.pairs);
  a.kitti_short = ComputeShortKittiErrors(a.pairs);
  AddOptionalMeasures(options, a);
  if (options.max_clock_offset_s > 0.0) {
    a.clock = FitClockOffset(estimate, truth, options.alignment, options.max_gap_ns, options.max_clock_offset_s);
  }
  a.note = Note(a, options);
  return a;
}

}  // namespace plslam::evaluate
