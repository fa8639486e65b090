#pragma once

#include <string>
#include <string_view>

#include "tools/evaluate/association.h"

namespace plslam {

/// How an estimate is brought into the frame of the truth before absolute errors are taken.
enum class Alignment {
  kNone,   ///< not at all
  kFirst,  ///< the first pose of both made equal
  kSe3,    ///< rotation and translation of least squares of the positions
  kSim3,   ///< the same with a scale
};

/// p_truth = scale * R * p_estimate + t.
struct Similarity {
  double scale = 1.0;
  SE3 T_truth_estimate;

  SE3 Apply(const SE3& pose) const;
};

/// Closed form of Umeyama (1991). Where the positions leave the rotation open (all on one line: the turn about the
/// line; all equal: everything), the rest is chosen so that the orientations agree best. No pairs: identity. Equal
/// positions: scale 1.
Similarity Align(const PosePairs& pairs, Alignment alignment);

/// "none", "first", "se3", "sim3"; the reverse throws std::runtime_error for any other name.
std::string AlignmentName(Alignment alignment);
Alignment AlignmentFromName(std::string_view name);

}  // namespace plslam
