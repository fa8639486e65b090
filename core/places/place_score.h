#pragma once

#include <string>

#include "core/places/place_description.h"

namespace plslam {

/// How similarities of points and of lines become one.
enum class PlaceMerge {
  kPaper,       ///< s_t of PL-SLAM §VI.A.1: half by strength, half by dispersion
  kPoints,      ///< points alone
  kLines,       ///< lines alone
  kStrength,    ///< by the share of each kind in the number of features
  kDispersion,  ///< by the share of each kind in the sum of the dispersions
};

/// From the value of `PlaceOptions::merge`; throws std::invalid_argument for another.
PlaceMerge PlaceMergeFromName(const std::string& name);

/// Weights of the two kinds, each at least 0, sum 1.
struct PlaceWeights {
  double points = 0.5;
  double lines = 0.5;
};

/// Weights for the places that are compared with `query`. A share of nothing in nothing is one half.
PlaceWeights WeightsFor(const PlaceDescription& query, PlaceMerge merge);

}  // namespace plslam
