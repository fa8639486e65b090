// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "core/features/features.h"
#include "core/features/image/gradients.h"

namespace plslam {

/// Line Band Descriptor (Zhang & Koch 2013; PL-SLAM §IV.B), all in integers.
///
/// Nine bands parallel to the segment, each `kLbdBandWidth` rows wide, are centred on it; a row has up to `kLbdSamples`
/// nearest-pixel samples spread over the length of the segment. In the segment's own frame (along its direction, and
/// across towards the brighter side, so rotation does not matter) the gradients of each row are summed by component and
/// sign. The descriptor of a band is the weighted mean and the variance of these four sums over the rows of the band
/// and its neighbours; weights decrease linearly from the band's middle, and from the segment outwards, where the
/// original uses Gaussians.
///
/// Bits compare bands: the means of all 36 pairs of bands (144 bits), and the variances of the 28 pairs that are not
/// neighbours (112 bits).
constexpr int kLbdBands = 9;
constexpr int kLbdBandWidth = 5;
constexpr int kLbdRows = kLbdBands * kLbdBandWidth;
constexpr int kLbdSamples = 32;
constexpr int kLbdChannels = 4;

/// Sums of one row: gradient across (positive, negative part), along (positive, negative part).
using LbdRow = std::array<int32_t, kLbdChannels>;

/// Mean and variance of the four sums over the rows of a band and its neighbours.
struct LbdBand {
  std::array<int64_t, kLbdChannels> mean{};
  std::array<int64_t, kLbdChannels> variance{};
};

/// Returns the descriptor of a directed segment of positive length; parts outside the image repeat its outermost
/// pixels. Zeros for an empty image.
Descriptor ComputeLbd(const Gradients& gradients, const Segment2& segment);

/// Its steps, for tests: rows from gradients, bands from rows, bits from bands.
std::array<LbdRow, kLbdRows> LbdRows(const Gradients& gradients, const Segment2& segment);
std::array<LbdBand, kLbdBands> LbdBands(const std::array<LbdRow, kLbdRows>& rows);
Descriptor LbdBits(const std::array<LbdBand, kLbdBands>& bands);

}  // namespace plslam
