#pragma once

#include <vector>

#include "core/places/options.h"
#include "core/places/place_description.h"

namespace plslam {

/// Weights of the two kinds in the score of a place, each at least 0, sum at most 1.
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
///   adaptive    the same, with 20 points more that no other image shares
///   points, lines   one kind alone
///
/// Why "balanced": the similarity of two unrelated images spreads the more the fewer features it is made of, and what lines add
/// is in part what points have said already (identical doors are identical in both). The weights with the smallest
/// spread for unrelated images are near those of n, and lower for lines; docs/places.md has the numbers.
///
/// "adaptive" has the 20 because the similarity of two unrelated images is large by chance where few features make it up.
///
/// A share of nothing in nothing is one half. Throws std::invalid_argument for an unknown merge.
PlaceWeights WeightsFor(const PlaceDescription& query, const PlaceOptions& options);

/// What each word of a query counts: 1, but in "adaptive" the power `rarity` of the share of places without it. What every
/// door of a corridor has says nothing there about where one is, however rare it was in training. `places_with[i]` of
/// `places` have word i; five more without any word keep a small map from judging.
std::vector<float> WordWorths(const std::vector<int>& places_with, int places, const PlaceOptions& options);

}  // namespace plslam
