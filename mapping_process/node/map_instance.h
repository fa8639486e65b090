// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace plslam::mapping {

/// Returns the instance (`BelongsTo` in core/map/map_update.h) of a map that begins with the run `source` of
/// mapping_process: even, and different from `source`, so that logs distinguish maps from processes.
inline int64_t BeginningInstance(int64_t source) {
  constexpr int64_t kDiffers = int64_t{1} << 40;
  return (source ^ kDiffers) & ~int64_t{1};
}

}  // namespace plslam::mapping
