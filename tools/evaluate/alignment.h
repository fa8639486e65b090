// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "core/accuracy/association.h"
#include "core/config/choices.h"
#include "core/geometry/similarity.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam::evaluate {

/// How an estimate is brought into the frame of the truth before absolute errors are taken.
enum class Alignment {
  kNone,   ///< not at all
  kFirst,  ///< the first pose of both made equal
  kSe3,    ///< rotation and translation of least squares of the positions
  kSim3,   ///< the same with a scale
};
constexpr auto ChoicesOf(Alignment) {
  return std::array{Choice{"none", Alignment::kNone}, Choice{"first", Alignment::kFirst},
                    Choice{"se3", Alignment::kSe3}, Choice{"sim3", Alignment::kSim3}};
}

inline bool IsLeastSquares(Alignment alignment) {
  return alignment == Alignment::kSe3 || alignment == Alignment::kSim3;
}

/// Returns the transform from the estimate (b of the similarity) to the truth (a), by `AlignPaths` for least squares.
/// No pairs: identity.
Similarity Align(const PosePairs& pairs, Alignment alignment);

/// Returns the rotation that aligns the orientations. For least squares it is their own mean rotation: on a nearly
/// straight path, positions leave the roll about it free.
Eigen::Quaterniond AlignOrientations(const PosePairs& pairs, Alignment alignment);

/// Offset between the clocks of an estimate and of the truth, as far as the paths determine it. Truth from another
/// sensor than the images is often some milliseconds early or late, which appears as an error of position when the
/// camera moves.
struct ClockOffset {
  double offset_s = 0.0;   ///< to add to the times of the estimate
  double ate_m = 0.0;      ///< root mean square there
  double ate_now_m = 0.0;  ///< the same, of the same poses, without it
};

/// The offset of at most `max_s` at which the absolute error is least, among poses that have an interpolated truth at
/// all of them; to a tenth of a millisecond; nullopt where fewer than three have, or the least lies at the limit.
std::optional<ClockOffset> FitClockOffset(const Trajectory& estimate, const Trajectory& truth, Alignment alignment,
                                          int64_t max_gap_ns, double max_s);

}  // namespace plslam::evaluate
