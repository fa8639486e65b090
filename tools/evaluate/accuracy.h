// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/accuracy/consistency.h"
#include "core/io/trajectories/pose_covariance.h"
#include "core/io/trajectories/trajectory.h"
#include "tools/evaluate/alignment.h"
#include "tools/evaluate/trajectory_errors.h"

namespace plslam::evaluate {

/// Options of the comparison. docs/metrics.md defines every number.
struct EvaluateOptions {
  Alignment alignment = Alignment::kSe3;
  /// Largest time difference of associated poses.
  int64_t max_difference_ns = 20'000'000;
  /// Compare with the truth interpolated at the time of the estimate, across gaps up to this, instead of the nearest
  /// true pose.
  bool interpolate_truth = false;
  int64_t max_gap_ns = 500'000'000;
  /// Intervals of the relative pose error.
  std::vector<Delta> deltas{{1.0, Delta::Unit::kFrames}, {1.0, Delta::Unit::kSeconds}, {1.0, Delta::Unit::kMetres}};
  /// Frames that could have had a pose; 0: as many as there are true poses.
  int64_t n_frames = 0;
  /// Times of the keyframes, of the covariances of poses, and of motions; empty: not evaluated.
  std::vector<int64_t> keyframe_t_ns;
  std::vector<PoseCovariance> covariances;
  std::vector<PoseCovariance> motion_covariances;
  /// Largest offset of the clocks to look for; 0: none is looked for.
  double max_clock_offset_s = 0.0;
};

/// Frames over which a filter adds up motions until something else corrects it: errors that frames have in common
/// show.
constexpr size_t kConsistencySpan = 20;

struct RelativeErrorSummary {
  Delta delta;
  Statistics translation_m;
  Statistics rotation_deg;
};

/// All measures of an estimate against the truth. Never NaN: a measure without samples is zero, and its count says so.
/// Overflow is infinite, and the note says so.
struct Accuracy {
  int estimated_poses = 0;
  int true_poses = 0;
  PosePairs pairs;
  /// Share of poses in the estimate, of `n_frames` or of the true poses.
  double coverage_percent = 0.0;
  double true_path_m = 0.0;
  /// Root mean square of the distances of the true positions, of the pairs, from their mean.
  double true_spread_m = 0.0;
  double duration_s = 0.0;
  Alignment alignment_kind = Alignment::kSe3;
  Similarity alignment;
  /// Sigma of the rotation about the path, of the alignment by least squares (`RollSigma_rad`).
  std::optional<double> roll_sigma_deg;
  AbsoluteErrors absolute;  ///< one for each pair
  Statistics ate_m;
  Statistics ate_deg;
  std::vector<RelativeErrorSummary> relative;
  KittiErrors kitti;
  KittiErrors kitti_short;
  std::optional<KeyframeErrors> keyframes;
  std::optional<Consistency> pose_consistency;
  std::optional<Consistency> motion_consistency;
  std::optional<Consistency> span_consistency;  ///< over `kConsistencySpan` frames
  /// All other values are without it.
  std::optional<ClockOffset> clock;
  /// A sentence about an obstacle ("no pose of the estimate is within 0.02 s of a true one").
  std::string note;
};

Accuracy EvaluateTrajectory(const Trajectory& estimate, const Trajectory& truth, const EvaluateOptions& options);

/// Returns `ate_m` (rmse) first, null if no poses are associated or it is not finite (so are all others then); the
/// counts, errors and tables by name. Leaves the pairs out.
nlohmann::ordered_json ToJson(const Accuracy& accuracy);

/// Returns the numbers of an evaluation as aligned lines for a terminal; "-" for missing measurements.
std::string AccuracyTable(const Accuracy& accuracy);

}  // namespace plslam::evaluate
