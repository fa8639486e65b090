// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/matching/hamming.h"

#include <bit>

#include "core/features/image/vector_kernels.h"

namespace plslam {

PLSLAM_POPCNT_CLONES
int HammingDistance(const Descriptor& a, const Descriptor& b) {
  return std::popcount(a[0] ^ b[0]) + std::popcount(a[1] ^ b[1]) + std::popcount(a[2] ^ b[2]) +
         std::popcount(a[3] ^ b[3]);
}

PLSLAM_POPCNT_CLONES
void HammingDistances(const Descriptor& query, const Descriptor* descriptors, int count, uint16_t* distances) {
  const uint64_t q0 = query[0];
  const uint64_t q1 = query[1];
  const uint64_t q2 = query[2];
  const uint64_t q3 = query[3];
  for (int i = 0; i < count; ++i) {
    const uint64_t* d = descriptors[i].data();
    distances[i] = static_cast<uint16_t>(std::popcount(q0 ^ d[0]) + std::popcount(q1 ^ d[1]) +
                                         std::popcount(q2 ^ d[2]) + std::popcount(q3 ^ d[3]));
  }
}

}  // namespace plslam
