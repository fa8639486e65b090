// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/features/features.h"

namespace plslam {

/// Writes the distances of `query` to `count` consecutive descriptors to `distances`; most of the time of brute-force
/// matching.
void HammingDistances(const Descriptor& query, const Descriptor* descriptors, int count, uint16_t* distances);

/// Returns a feature of one image itself, and the left feature of a stereo feature.
template <class Feature>
const auto& InLeftImage(const Feature& feature) {
  if constexpr (requires { feature.left; }) {
    return feature.left;
  } else {
    return feature;
  }
}

/// Returns the descriptors of points or lines, of one image or of stereo features, in their order.
template <class Features>
std::vector<Descriptor> DescriptorsOf(const Features& features) {
  std::vector<Descriptor> descriptors;
  descriptors.reserve(features.size());
  for (const auto& feature : features) descriptors.push_back(InLeftImage(feature).descriptor);
  return descriptors;
}

}  // namespace plslam
