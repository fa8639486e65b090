// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "core/accuracy/association.h"
#include "core/geometry/similarity.h"

namespace plslam {

/// How an estimate is brought into the frame of the truth before absolute errors are taken.
enum class Alignment {
  kNone,   ///< not at all
  kFirst,  ///< the first pose of both made equal
  kSe3,    ///< rotation and translation of least squares of the positions
  kSim3,   ///< the same with a scale
};

/// Takes the estimate (b of the similarity) to the truth (a), by `AlignPaths` where it is of least squares. No pairs:
/// identity.
Similarity Align(const PosePairs& pairs, Alignment alignment);

/// "none", "first", "se3", "sim3"; the reverse throws std::runtime_error for any other name.
std::string AlignmentName(Alignment alignment);
Alignment AlignmentFromName(std::string_view name);

}  // namespace plslam
