// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tools/evaluate/alignment.h"

namespace plslam::evaluate {

/// Absolute trajectory error of each pair (Sturm et al. 2012): distance of the positions after their alignment
/// (`Align`), and the angle between the orientations after theirs (`AlignOrientations`).
struct AbsoluteErrors {
  std::vector<double> translation_m;
  std::vector<double> rotation_rad;
};

AbsoluteErrors ComputeAbsoluteErrors(const PosePairs& pairs, const Similarity& positions,
                                     const Eigen::Quaterniond& orientations);

/// Angle of the rotation between two orientations, in [0, pi].
double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

/// The interval over which relative pose errors are taken.
struct Delta {
  enum class Unit { kFrames, kSeconds, kMetres };
  double value = 1.0;
  Unit unit = Unit::kFrames;
};

/// Parses "5f", "1s", "2.5m"; throws std::runtime_error for other text, or a value that is not positive (frames: an
/// integer).
Delta DeltaFromText(std::string_view text);
std::string DeltaText(const Delta& delta);

struct RelativeErrors {
  std::vector<double> translation_m;
  std::vector<double> rotation_rad;
};

/// Relative pose error (Sturm et al. 2012, eq. 1): E_i = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) for truth Q and estimate P, from
/// every pair i to the pair j one `delta` later. Frames count associated pairs. For seconds and metres (of the true
/// path) j is the one nearest to the delta, and i is left out if that differs by more than half the delta, or the
/// sequence ends before.
RelativeErrors ComputeRelativeErrors(const PosePairs& pairs, const Delta& delta);

/// Length of the true path up to each pair.
std::vector<double> TruePath_m(const PosePairs& pairs);

/// Errors of the motion between consecutive keyframes, the measure of PL-SLAM's tables (§VII: "relative errors between
/// the KFs positions"). The paper prints no formula; docs/metrics.md has our interpretation.
struct KeyframeErrors {
  int motions = 0;
  double rmse_m = 0.0;              ///< translation error of a motion
  double rmse_deg = 0.0;            ///< rotation error of a motion
  int moving = 0;                   ///< motions of at least 1 cm; the relative figures are over these
  double relative_rmse = 0.0;       ///< of translation error / true distance
  double t_rel_percent = 0.0;       ///< mean of the same
  double R_rel_deg_per_100m = 0.0;  ///< mean of rotation error / true distance
};

/// `keyframe_t_ns` are the times of the keyframes in the estimated trajectory, increasing. Keyframes without an
/// associated true pose are skipped.
KeyframeErrors ComputeKeyframeErrors(const PosePairs& pairs, const std::vector<int64_t>& keyframe_t_ns);

/// Mean errors over the segments of one length.
struct KittiLengthError {
  double length_m = 0.0;
  int segments = 0;
  double t_rel_percent = 0.0;
  double r_rel_deg_per_100m = 0.0;
};

/// Mean over all segments of all lengths, and one row for each length that has a segment.
struct KittiErrors {
  int segments = 0;
  double t_rel_percent = 0.0;
  double r_rel_deg_per_100m = 0.0;
  std::vector<KittiLengthError> lengths;
};

/// The odometry metric of the KITTI development kit (Geiger et al. 2012; `calcSequenceErrors` of its
/// evaluate_odometry): from every `step`-th pose, for each length, to the first pose whose true path length exceeds
/// that of the start by the length; error = inverse(estimated motion) * true motion; translation and rotation angle
/// divided by the length; mean over all segments. Poses are the associated ones, in order.
KittiErrors ComputeKittiErrors(const PosePairs& pairs, const std::vector<double>& lengths_m, int step);

/// 100, 200, ..., 800 m from every tenth pose: the kit's own.
KittiErrors ComputeKittiErrors(const PosePairs& pairs);

/// The same for sequences too short for the kit: 10, 20, ..., 50 m from every pose. No figure of the benchmark.
KittiErrors ComputeShortKittiErrors(const PosePairs& pairs);

}  // namespace plslam::evaluate
