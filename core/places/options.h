// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/config/fields.h"

namespace plslam {

/// Comparison of places.
struct PlaceOptions {
  /// Combination of the similarities of points and lines (see place_index.h).
  std::string merge = "adaptive";
  /// Weight of a line relative to a point in "adaptive" and "balanced".
  double line_weight = 0.5;
  /// In "adaptive" a word is weighted by this power of the share of places without it.
  double idf_exponent = 1.5;
};

template <class Visitor>
void VisitFields(Visitor& visit, PlaceOptions& o) {
  visit("merge", o.merge, OneOf{"adaptive", "balanced", "paper", "strength", "dispersion", "points", "lines"},
        "how the similarities of points and lines are weighted: adaptive (number of features, line weight, inverse "
        "frequency of words in the map), balanced (the same without word frequencies), paper (number and "
        "dispersion), strength (number), dispersion, or one feature type only");
}

}  // namespace plslam
