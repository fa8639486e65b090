// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "core/features/features.h"

namespace plslam::train_vocabulary {

/// The descriptor in which each bit is set that more than half of the added ones have: the centre of a cluster for the
/// Hamming distance.
///
/// Counts all 256 bits at once in eight bit planes (plane i holds bit i of the counts), emptied before they overflow.
class MajorityVote {
 public:
  void Add(const Descriptor& descriptor);
  int64_t count() const { return count_; }
  Descriptor Majority();

 private:
  static constexpr int kPlanes = 8;
  void Empty();

  std::array<Descriptor, kPlanes> planes_{};
  int in_planes_ = 0;
  int64_t count_ = 0;
  std::array<int64_t, 256> ones_{};
};

/// Descriptors around a centre.
struct DescriptorCluster {
  Descriptor center{};
  /// Indices of the descriptors, ascending.
  std::vector<int32_t> members;
};

/// k-majority: Lloyd's algorithm for the Hamming distance, with the majority of the bits as centre. Clusters those of
/// `all` that `members` lists (ascending); seeds are drawn as in k-means++. At most `k` clusters, none empty; equal
/// distances: the first centre. Equal input and state of `random` give equal clusters on every machine.
std::vector<DescriptorCluster> ClusterDescriptors(const std::vector<Descriptor>& all,
                                                  const std::vector<int32_t>& members, int k, int max_iterations,
                                                  std::mt19937_64& random);

}  // namespace plslam::train_vocabulary
