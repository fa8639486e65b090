// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/packed_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "core/files/archive.h"
#include "dense_process/surface.h"

namespace plslam::dense {
namespace {

constexpr double kPackedVoxel_m = 0.05;

/// A wall at 2 m, seen from several places, with weights and greys of all sizes.
Volume Wall() {
  Volume volume(kPackedVoxel_m);
  for (int i = 0; i < 4; ++i) {
    std::vector<DepthRay> rays;
    for (double y = -1.0; y <= 1.0; y += kPackedVoxel_m) {
      for (double x = -1.0; x <= 1.0; x += kPackedVoxel_m)
        rays.push_back(
            {{x, y, 2.017}, static_cast<float>(0.05 + 0.2 * (1.0 + x)), static_cast<float>(120.0 + 100.0 * y)});
    }
    volume.Integrate({0.1 * i, 0.0, 0.0}, rays);
  }
  return volume;
}

using Voxels = std::map<std::tuple<int, int, int>, Volume::Voxel>;
Voxels VoxelsOf(const Volume& volume) {
  Voxels voxels;
  volume.Visit([&](const Volume::Voxel& v) { voxels[{v.index.x(), v.index.y(), v.index.z()}] = v; });
  return voxels;
}

TEST(PackedVolume, KeepsVoxelsToAFractionOfTheirErrors) {
  const Volume volume = Wall();
  const Volume unpacked = PackedVolume(volume).Unpack(kPackedVoxel_m);
  const Voxels before = VoxelsOf(volume);
  const Voxels after = VoxelsOf(unpacked);
  ASSERT_GT(before.size(), 10000U);
  ASSERT_EQ(before.size(), after.size());
  const auto truncation_m = static_cast<float>(Volume::kTruncation * kPackedVoxel_m);
  int n_free = 0;
  for (const auto& [index, voxel] : before) {
    ASSERT_TRUE(after.contains(index));
    const Volume::Voxel& kept = after.at(index);
    EXPECT_NEAR(kept.distance_m, voxel.distance_m, 1e-5F);
    EXPECT_EQ(kept.distance_m == truncation_m, std::abs(voxel.distance_m - truncation_m) < 2e-6F);
    if (voxel.weight >= 1.0F / 512.0F) {
      EXPECT_NEAR(kept.weight / voxel.weight, 1.0F, 1.0F / 32.0F);
    }
    EXPECT_NEAR(kept.grey, voxel.grey, 0.51F);
    n_free += kept.distance_m == truncation_m ? 1 : 0;
  }
  EXPECT_GT(n_free, 1000);
  const Surface one = ExtractSurface(volume), two = ExtractSurface(unpacked);
  EXPECT_NEAR(static_cast<double>(one.vertices.size()), static_cast<double>(two.vertices.size()),
              0.02 * static_cast<double>(one.vertices.size()));
}

TEST(PackedVolume, PackingAgainChangesNothing) {
  const PackedVolume packed(Wall());
  const Volume unpacked = packed.Unpack(kPackedVoxel_m);
  const PackedVolume again(unpacked);
  EXPECT_EQ(archive::ToBytes(packed), archive::ToBytes(again));
  EXPECT_EQ(packed.n_voxels(), unpacked.n_voxels());
}

TEST(PackedVolume, KnownWeightsRemainKnown) {
  Volume::Block block;
  block.known[0] = 0b11111;
  for (const float weight : {kLeastKnown, 3.0F, 32.0F, 100.0F, 1e-4F})
    block.sums.insert(block.sums.end(), {0.0F, weight, 0.0F});
  const Volume unpacked = PackedVolume(Volume::FromBlocks(kPackedVoxel_m, std::vector{block})).Unpack(kPackedVoxel_m);
  std::vector<float> weights;
  unpacked.Visit([&](const Volume::Voxel& voxel) { weights.push_back(voxel.weight); });
  EXPECT_EQ(weights, (std::vector{kLeastKnown, 3.0F, 32.0F, 100.0F})) << "the last one is rounding";
}

TEST(PackedVolume, TakesATenthOfTheMemory) {
  const Volume volume = Wall();
  const PackedVolume packed(volume);
  printf("%zu kB, packed %zu kB\n", volume.bytes() / 1000, packed.bytes() / 1000);
  EXPECT_LT(10 * packed.bytes(), volume.bytes());
  EXPECT_EQ(PackedVolume().bytes(), 0U);
}

TEST(PackedVolume, ImpossibleContentIsRefused) {
  const std::vector<uint8_t> bytes = archive::ToBytes(PackedVolume(Wall()));
  const auto read = [](const std::vector<uint8_t>& damaged) {
    PackedVolume packed;
    archive::FromBytes(damaged, packed);
    packed.Unpack(kPackedVoxel_m);
  };
  EXPECT_NO_THROW(read(bytes));
  // The origin of the first block, its known voxels, and the first weight.
  for (const size_t at : {size_t{8}, size_t{25}}) {
    std::vector<uint8_t> damaged = bytes;
    damaged[at] ^= 0x01;
    EXPECT_THROW(read(damaged), std::runtime_error) << at;
  }
  uint64_t n_blocks = 0;
  archive::FromBytes(std::vector<uint8_t>(bytes.begin(), bytes.begin() + 8), n_blocks);
  std::vector<uint8_t> heavy = bytes;
  heavy[8 + n_blocks * 140 + 8] = 0xFF;
  EXPECT_THROW(read(heavy), std::runtime_error) << "more than the largest weight";
}

}  // namespace
}  // namespace plslam::dense
