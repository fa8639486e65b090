// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <cstddef>

namespace plslam {

/// Eigen cuts large dense matrices into blocks that fit the caches of the processor, and sums in their order. From the
/// first call on these are blocks of one size, so that every processor gives the same bits.
inline void UseEqualDenseBlocks() {
  constexpr std::ptrdiff_t kKiB = 1024;
  static const bool are_set = [] {
    Eigen::setCpuCacheSizes(48 * kKiB, 2048 * kKiB, 16384 * kKiB);
    return true;
  }();
  static_cast<void>(are_set);
}

}  // namespace plslam
