// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/features/features.h"

namespace plslam {

/// Distances of `query` to `count` descriptors in a row, into `distances`; what brute-force matching spends its time
/// on.
void HammingDistances(const Descriptor& query, const Descriptor* descriptors, int count, uint16_t* distances);

/// A feature of one image as it is, of a stereo feature that in the left one.
template <class Feature>
const auto& InLeftImage(const Feature& feature) {
  if constexpr (requires { feature.left; }) {
    return feature.left;
  } else {
    return feature;
  }
}

/// Descriptors of points or lines, of one image or of stereo features, in their order.
template <class Features>
std::vector<Descriptor> DescriptorsOf(const Features& features) {
  std::vector<Descriptor> descriptors;
  descriptors.reserve(features.size());
  for (const auto& feature : features) descriptors.push_back(InLeftImage(feature).descriptor);
  return descriptors;
}

}  // namespace plslam
