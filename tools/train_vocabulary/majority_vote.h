// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "core/features/features.h"

namespace plslam {

/// The descriptor that has each bit set which more than half of the added ones have: the centre of a cluster whose
/// distance is the Hamming distance.
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

}  // namespace plslam
