// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/features/features.h"
#include "core/features/options.h"
#include "core/places/vocabulary.h"

namespace plslam::loop {

/// Returns for each descriptor of `a` the index of its match in `b`, or -1: as `MatchBruteForce`, but only among
/// descriptors of the same vocabulary node. A hundredth of the comparisons finds about two thirds of the matches.
std::vector<int> MatchByNodes(const std::vector<Descriptor>& a, const FeatureNodes& nodes_a,
                              const std::vector<Descriptor>& b, const FeatureNodes& nodes_b,
                              const MatchOptions& options);

}  // namespace plslam::loop
