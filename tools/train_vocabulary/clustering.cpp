// SPDX-License-Identifier: BSD-3-Clause
#include "tools/train_vocabulary/clustering.h"

#include <algorithm>
#include <bit>

#include "core/features/image/vector_kernels.h"

namespace plslam::train_vocabulary {

void MajorityVote::Add(const Descriptor& descriptor) {
  Descriptor carry = descriptor;
  for (Descriptor& plane : planes_) {
    uint64_t left = 0;
    for (size_t w = 0; w < carry.size(); ++w) {
      const uint64_t sum = plane[w] ^ carry[w];
      carry[w] &= plane[w];
      plane[w] = sum;
      left |= carry[w];
    }
    if (left == 0) break;
  }
  ++count_;
  if (++in_planes_ == (1 << kPlanes) - 1) Empty();
}

void MajorityVote::Empty() {
  for (int p = 0; p < kPlanes; ++p) {
    for (int bit = 0; bit < 256; ++bit)
      ones_[bit] += static_cast<int64_t>(planes_[p][bit / 64] >> (bit % 64) & 1U) << p;
  }
  planes_ = {};
  in_planes_ = 0;
}

Descriptor MajorityVote::Majority() {
  Empty();
  Descriptor majority{};
  for (int bit = 0; bit < 256; ++bit) {
    if (2 * ones_[bit] > count_) majority[bit / 64] |= uint64_t{1} << (bit % 64);
  }
  return majority;
}

namespace {

PLSLAM_POPCNT_CLONES
int NearestCenter(const Descriptor& d, const Descriptor* centers, int count) {
  int nearest = 0;
  int least = 257;
  for (int i = 0; i < count; ++i) {
    const Descriptor& c = centers[i];
    const int distance = std::popcount(c[0] ^ d[0]) + std::popcount(c[1] ^ d[1]) + std::popcount(c[2] ^ d[2]) +
                         std::popcount(c[3] ^ d[3]);
    nearest = distance < least ? i : nearest;
    least = std::min(least, distance);
  }
  return nearest;
}

/// Each further centre is drawn with the probability of the squared distance to the nearest one so far: never a copy
/// of it.
std::vector<Descriptor> DrawCenters(const std::vector<Descriptor>& all, const std::vector<int32_t>& members, int k,
                                    std::mt19937_64& random) {
  std::vector<Descriptor> centers{all[members[random() % members.size()]]};
  std::vector<uint64_t> square(members.size(), UINT64_MAX);
  while (static_cast<int>(centers.size()) < k) {
    uint64_t sum = 0;
    for (size_t i = 0; i < members.size(); ++i) {
      const auto distance = static_cast<uint64_t>(HammingDistance(all[members[i]], centers.back()));
      square[i] = std::min(square[i], distance * distance);
      sum += square[i];
    }
    if (sum == 0) break;
    uint64_t left = random() % sum;
    size_t i = 0;
    while (left >= square[i]) left -= square[i++];
    centers.push_back(all[members[i]]);
  }
  return centers;
}

/// The cluster of each member; whether any has changed.
bool Assign(const std::vector<Descriptor>& all, const std::vector<int32_t>& members,
            const std::vector<Descriptor>& centers, std::vector<int>& cluster) {
  bool changed = false;
  for (size_t i = 0; i < members.size(); ++i) {
    const int nearest = NearestCenter(all[members[i]], centers.data(), static_cast<int>(centers.size()));
    changed = changed || nearest != cluster[i];
    cluster[i] = nearest;
  }
  return changed;
}

/// A cluster without members keeps its centre.
void MoveCenters(const std::vector<Descriptor>& all, const std::vector<int32_t>& members,
                 const std::vector<int>& cluster, std::vector<Descriptor>& centers) {
  std::vector<MajorityVote> votes(centers.size());
  for (size_t i = 0; i < members.size(); ++i) votes[cluster[i]].Add(all[members[i]]);
  for (size_t c = 0; c < centers.size(); ++c) {
    if (votes[c].count() > 0) centers[c] = votes[c].Majority();
  }
}

}  // namespace

std::vector<DescriptorCluster> ClusterDescriptors(const std::vector<Descriptor>& all,
                                                  const std::vector<int32_t>& members, int k, int max_iterations,
                                                  std::mt19937_64& random) {
  if (members.empty()) return {};
  std::vector<Descriptor> centers = DrawCenters(all, members, k, random);
  std::vector<int> cluster(members.size(), -1);
  Assign(all, members, centers, cluster);
  for (int i = 0; i < max_iterations; ++i) {
    MoveCenters(all, members, cluster, centers);
    if (!Assign(all, members, centers, cluster)) break;
  }
  std::vector<DescriptorCluster> clusters(centers.size());
  for (size_t c = 0; c < centers.size(); ++c) clusters[c].center = centers[c];
  for (size_t i = 0; i < members.size(); ++i) clusters[cluster[i]].members.push_back(members[i]);
  std::erase_if(clusters, [](const DescriptorCluster& c) { return c.members.empty(); });
  return clusters;
}

}  // namespace plslam::train_vocabulary
