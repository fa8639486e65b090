// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "core/features/features.h"

namespace plslam {

/// Descriptors around a centre.
struct DescriptorCluster {
  Descriptor center{};
  /// Indices of the descriptors, ascending.
  std::vector<int32_t> members;
};

/// k-majority: Lloyd's algorithm for the Hamming distance, with the majority of the bits as centre. Of all the
/// descriptors those that `members` names (ascending); seeds are drawn as in k-means++. At most `k` clusters, none
/// empty; equal distances: the first centre. Equal input and state of `random` give equal clusters on every machine.
std::vector<DescriptorCluster> ClusterDescriptors(const std::vector<Descriptor>& all,
                                                  const std::vector<int32_t>& members, int k, int max_iterations,
                                                  std::mt19937_64& random);

}  // namespace plslam
