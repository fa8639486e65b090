// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <cstddef>

namespace plslam {

/// Eigen splits large dense matrices into blocks that fit the caches of the processor, which determines the order of
/// summation. After the first call the blocks have one size, so that all processors give the same bits.
inline void UseEqualDenseBlocks() {
  constexpr std::ptrdiff_t kKiB = 1024;
  static const bool are_set = [] {
    Eigen::setCpuCacheSizes(48 * kKiB, 2048 * kKiB, 16384 * kKiB);
    return true;
  }();
  static_cast<void>(are_set);
}

}  // namespace plslam
