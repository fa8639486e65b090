// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "core/config/choices.h"
#include "core/config/fields.h"

namespace plslam {

/// Combination of the similarities of points and lines (see place_index.h).
enum class Merge { kAdaptive, kBalanced, kPaper, kStrength, kDispersion, kPoints, kLines };
constexpr auto ChoicesOf(Merge) {
  return std::array{Choice{"adaptive", Merge::kAdaptive},
                    Choice{"balanced", Merge::kBalanced},
                    Choice{"paper", Merge::kPaper},
                    Choice{"strength", Merge::kStrength},
                    Choice{"dispersion", Merge::kDispersion},
                    Choice{"points", Merge::kPoints},
                    Choice{"lines", Merge::kLines}};
}

/// Comparison of places.
struct PlaceOptions {
  Merge merge = Merge::kAdaptive;
  /// Weight of a line relative to a point in `kAdaptive` and `kBalanced`.
  double line_weight = 0.5;
  /// In `kAdaptive` a word is weighted by this power of the share of places without it.
  double idf_exponent = 1.5;
};

template <class Visitor>
void VisitFields(Visitor& visit, PlaceOptions& o) {
  visit("merge", o.merge,
        "how the similarities of points and lines are weighted: adaptive (number of features, line weight, inverse "
        "frequency of words in the map), balanced (the same without word frequencies), paper (number and "
        "dispersion), strength (number), dispersion, or one feature type only");
}

}  // namespace plslam
