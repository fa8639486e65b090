// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/packed_volume.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace plslam::dense {
namespace {

// A weight is a float of 4 bits of exponent and 4 of mantissa: 2^-9 to 124.
constexpr int kMantissaBits = 4;
constexpr int kDropped = 23 - kMantissaBits;
constexpr uint32_t kSmallest = (127U - 9U) << kMantissaBits;

constexpr int16_t kFree = 32767;  // a truncation
constexpr float kDistances = kFree;

uint8_t PackWeight(float weight) {
  const uint32_t rounded = (std::bit_cast<uint32_t>(weight) + (1U << (kDropped - 1))) >> kDropped;
  return static_cast<uint8_t>(std::clamp(rounded, kSmallest, kSmallest + 255U) - kSmallest);
}

float UnpackWeight(uint8_t packed) { return std::bit_cast<float>((kSmallest + packed) << kDropped); }

bool IsSet(const std::array<uint64_t, 8>& bits, size_t position) {
  return (bits[position / 64] >> position % 64 & 1) != 0;
}

void Set(std::array<uint64_t, 8>& bits, size_t position) { bits[position / 64] |= uint64_t{1} << position % 64; }

}  // namespace

PackedVolume::PackedVolume(const Volume& volume) {
  for (const Volume::Block& block : volume.Blocks()) {
    Block packed{block.origin, {}, {}};
    size_t next = 0;
    bool is_empty = true;
    for (size_t position = 0; position < 512; ++position) {
      if (!IsSet(block.known, position)) continue;
      const float distance = block.sums[next], weight = block.sums[next + 1], grey = block.sums[next + 2];
      next += 3;
      if (weight < Volume::kLeastWeight) continue;
      is_empty = false;
      Set(packed.known, position);
      values_.push_back(PackWeight(weight));
      values_.push_back(static_cast<uint8_t>(std::lround(std::clamp(grey / weight, 0.0F, 255.0F))));
      const auto d = static_cast<int16_t>(std::lround(kDistances * std::clamp(distance / weight, -1.0F, 1.0F)));
      if (d == kFree) {
        Set(packed.free, position);
        continue;
      }
      values_.push_back(static_cast<uint8_t>(static_cast<uint16_t>(d) & 0xFF));
      values_.push_back(static_cast<uint8_t>(static_cast<uint16_t>(d) >> 8));
    }
    if (!is_empty) blocks_.push_back(packed);
  }
  blocks_.shrink_to_fit();
  values_.shrink_to_fit();
}

Volume PackedVolume::Unpack(double voxel_m) const {
  std::vector<Volume::Block> blocks;
  blocks.reserve(blocks_.size());
  size_t next = 0;
  const auto take = [&] {
    if (next == values_.size()) throw std::runtime_error("a submap has fewer voxels than it states");
    return values_[next++];
  };
  for (const Block& packed : blocks_) {
    Volume::Block& block = blocks.emplace_back(Volume::Block{packed.origin, packed.known, {}});
    for (size_t position = 0; position < 512; ++position) {
      if (!IsSet(packed.known, position)) continue;
      const float weight = UnpackWeight(take());
      const float grey = take();
      float distance = 1.0F;
      if (!IsSet(packed.free, position)) {
        const uint16_t low = take();
        const auto d = static_cast<int16_t>(static_cast<uint16_t>(low | take() << 8));
        distance = d / kDistances;
      }
      block.sums.insert(block.sums.end(), {weight * distance, weight, weight * grey});
    }
  }
  if (next != values_.size()) throw std::runtime_error("a submap has more voxels than it states");
  return Volume::FromBlocks(voxel_m, blocks);
}

size_t PackedVolume::n_voxels() const {
  size_t n = 0;
  for (const Block& block : blocks_) {
    for (const uint64_t bits : block.known) n += static_cast<size_t>(std::popcount(bits));
  }
  return n;
}

size_t PackedVolume::bytes() const { return blocks_.capacity() * sizeof(Block) + values_.capacity(); }

}  // namespace plslam::dense
