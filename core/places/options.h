#pragma once

#include <string>

#include "core/config/fields.h"

namespace plslam {

/// How places are compared.
struct PlaceOptions {
  /// How the scores of points and lines become one (see place_score.h).
  std::string merge = "paper";
};

template <class Visitor>
void VisitFields(Visitor& visit, PlaceOptions& o) {
  visit("merge", o.merge, OneOf{"paper", "points", "lines", "strength", "dispersion"},
        "how the similarities of points and lines become one: by number and dispersion of the features (the "
        "paper's), one "
        "kind alone, by number alone, by dispersion alone");
}

}  // namespace plslam
