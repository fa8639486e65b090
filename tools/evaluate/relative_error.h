// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/accuracy/association.h"

namespace plslam {

/// The interval over which relative pose errors are taken.
struct Delta {
  enum class Unit { kFrames, kSeconds, kMetres };
  double value = 1.0;
  Unit unit = Unit::kFrames;
};

/// "5f", "1s", "2.5m"; throws std::runtime_error for anything else, or where it is not positive (frames: whole).
Delta DeltaFromText(std::string_view text);
std::string DeltaText(const Delta& delta);

struct RelativeErrors {
  std::vector<double> translation_m;
  std::vector<double> rotation_rad;
};

/// Relative pose error (Sturm et al. 2012, eq. 1): E_i = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) for truth Q and estimate P,
/// from every pair i to the pair j one `delta` later. Frames count associated pairs. For seconds and metres (of the
/// true path) j is the one nearest to the delta, and i is left out where that is off by more than half the delta, or
/// the sequence ends before.
RelativeErrors ComputeRelativeErrors(const PosePairs& pairs, const Delta& delta);

/// Length of the true path up to each pair.
std::vector<double> TruePath_m(const PosePairs& pairs);

}  // namespace plslam
