#pragma once

#include <string>

#include "core/config/fields.h"

namespace plslam {

/// How places are compared.
struct PlaceOptions {
  /// How the similarities of points and lines become one (see place_score.h).
  std::string merge = "balanced";
  /// What a line counts in "balanced", in points.
  double line_worth = 0.5;
};

template <class Visitor>
void VisitFields(Visitor& visit, PlaceOptions& o) {
  visit("merge", o.merge, OneOf{"balanced", "paper", "strength", "dispersion", "points", "lines"},
        "weights of the similarities of points and lines: by number with lines at their worth, by number and "
        "dispersion "
        "(the paper's), by number, by dispersion, one kind alone");
  visit("line_worth", o.line_worth, Bounds{0, 1000}, "what a line counts in balanced, in points");
}

}  // namespace plslam
