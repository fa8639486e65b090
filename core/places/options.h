// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/config/fields.h"

namespace plslam {

/// How places are compared.
struct PlaceOptions {
  /// How the similarities of points and lines become one (see place_index.h).
  std::string merge = "adaptive";
  /// What a line counts in "adaptive" and "balanced", in points.
  double line_weight = 0.5;
  /// In "adaptive" a word counts by this power of the share of places without it.
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
