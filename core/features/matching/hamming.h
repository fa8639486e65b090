#pragma once

#include <cstdint>

#include "core/features/features.h"

namespace plslam {

/// Distances of `query` to `count` descriptors in a row, into `distances`; what brute-force matching spends its time on.
void HammingDistances(const Descriptor& query, const Descriptor* descriptors, int count, uint16_t* distances);

}  // namespace plslam
