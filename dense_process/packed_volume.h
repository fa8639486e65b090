// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dense_process/volume.h"

namespace plslam::dense {

/// A volume that is only read, in about a tenth of its memory: known voxels alone, with a distance of 16 bits (a
/// ten-thousandth of a voxel), a weight of 8 bits (to 3 %; integers up to 32 and the largest weight are exact) and a grey
/// value of 8 bits. Free space, which most voxels are, has no distance. Packing what was unpacked changes nothing.
class PackedVolume {
 public:
  PackedVolume() = default;
  explicit PackedVolume(const Volume& volume);

  /// Throws std::runtime_error for content that no volume has.
  Volume Unpack(double voxel_m) const;

  size_t n_voxels() const;
  size_t bytes() const;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.blocks_, self.values_);
  }

 private:
  /// A block of a volume (Volume::Block).
  struct Block {
    std::array<int32_t, 3> origin{};
    std::array<uint64_t, 8> known{};
    std::array<uint64_t, 8> free{};  ///< of these, a truncation or more in front of all surfaces

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.origin, self.known, self.free);
    }
  };
  std::vector<Block> blocks_;
  /// For each known voxel: weight, grey and, unless it is free, two bytes of distance, the lower one first.
  std::vector<uint8_t> values_;
};

}  // namespace plslam::dense
