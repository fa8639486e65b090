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
        "weights of the similarities of points and lines: by number with lines at their worth and words by their "
        "rarity in the map, the same with all words alike, by number and dispersion (the paper's), by number, by "
        "dispersion, one feature type alone");
}

}  // namespace plslam
