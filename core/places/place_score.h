#pragma once

#include "core/places/options.h"
#include "core/places/place_description.h"

namespace plslam {

/// Weights of the two kinds in the score of a place, each at least 0, sum 1.
struct PlaceWeights {
  double points = 0.5;
  double lines = 0.5;
};

/// Weights for all places that are compared with `query` (PL-SLAM §VI.A.1). With n features of a kind and dispersion d:
///
///   paper       half by n, half by d: s_t of the paper
///   strength    by n
///   dispersion  by d
///   balanced    by n, each line counted as `line_worth` points
///   points, lines   one kind alone
///
/// Why "balanced": the similarity of two unrelated images spreads the more the fewer features it is made of, and what lines add
/// is in part what points have said already (identical doors are identical in both). The weights with the smallest
/// spread for unrelated images are near those of n, and lower for lines; docs/places.md has the numbers.
///
/// A share of nothing in nothing is one half. Throws std::invalid_argument for an unknown merge.
PlaceWeights WeightsFor(const PlaceDescription& query, const PlaceOptions& options);

}  // namespace plslam
