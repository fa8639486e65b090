#pragma once

#include <vector>

#include "core/features/features.h"

namespace plslam {

/// Descriptors of points or lines, of one image or of stereo features, in their order.
template <class Feature>
std::vector<Descriptor> DescriptorsOf(const std::vector<Feature>& features) {
  std::vector<Descriptor> descriptors;
  descriptors.reserve(features.size());
  for (const Feature& feature : features) {
    if constexpr (requires { feature.left; }) {
      descriptors.push_back(feature.left.descriptor);
    } else {
      descriptors.push_back(feature.descriptor);
    }
  }
  return descriptors;
}

}  // namespace plslam
