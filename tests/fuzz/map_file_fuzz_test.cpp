// SPDX-License-Identifier: BSD-3-Clause
// Mutates map files, with a corrected checksum so that the content is checked: a map that is accepted must be valid and
// saved as the same bytes, and memory must stay within a bound of the file.
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/fuzzing.h"
#include "tests/unit/bus/allocation_counter.h"
#include "tests/unit/map_file/stored_maps.h"

namespace plslam {
namespace {

using Random = std::mt19937_64;
using ByteVector = std::vector<uint8_t>;

void Mutate(ByteVector& bytes, Random& random) {
  const uint64_t words[] = {0,
                            1,
                            0xFF,
                            0x7FFFFFFF,
                            0xFFFFFFFF,
                            0x7FFFFFFFFFFFFFFF,
                            0xFFFFFFFFFFFFFFFF,
                            0x7FF0000000000000,
                            0x7FF8000000000000,
                            1ULL << 40};
  for (uint64_t n = 1 + random() % 4; n > 0 && bytes.size() > 64; --n) {
    // Counts and ids are mostly near the beginning.
    const size_t range = random() % 2 == 0 ? bytes.size() : std::min<size_t>(bytes.size(), 1000);
    const size_t at = random() % range;
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    switch (random() % 5) {
      case 0:
        bytes[at] ^= static_cast<uint8_t>(1U << (random() % 8));
        break;
      case 1:
        bytes[at] = static_cast<uint8_t>(random());
        break;
      case 2:
        bytes.insert(place, random() % 40, static_cast<uint8_t>(random()));
        break;
      case 3:
        bytes.erase(place, place + static_cast<std::ptrdiff_t>(std::min<size_t>(random() % 40, bytes.size() - at)));
        break;
      default:
        std::memcpy(bytes.data() + std::min(at, bytes.size() - 8), &words[random() % std::size(words)], 8);
    }
  }
}

/// Returns true if the bytes are accepted.
bool DecodesSoundly(const ByteVector& bytes) {
  bus::test::allocated = 0;
  StoredMap stored;
  try {
    stored = DecodeMap(bytes);
  } catch (const std::runtime_error& error) {
    EXPECT_FALSE(std::string(error.what()).empty());
    EXPECT_LE(bus::test::allocated, 40 * bytes.size() + 10'000);
    return false;
  }
  EXPECT_LE(bus::test::allocated, 40 * bytes.size() + 10'000);
  for (const auto& [id, keyframe] : stored.map.keyframes()) EXPECT_TRUE(keyframe.T_w_kf.IsFinite());
  for (const auto& [id, point] : stored.map.points()) {
    EXPECT_TRUE(point.p_w.allFinite());
    for (const Observation& observation : point.observations) {
      EXPECT_LT(static_cast<size_t>(observation.feature),
                stored.features.at(observation.keyframe_id()).points.size());
    }
  }
  // Covariances of landmarks are rounded to single precision, once.
  const ByteVector again = EncodeMap(stored);
  EXPECT_EQ(again.size(), bytes.size());
  EXPECT_EQ(EncodeMap(DecodeMap(again)), again);
  return true;
}

std::vector<ByteVector> SmallMaps() {
  std::vector<ByteVector> maps;
  for (const int steps : {0, 3, 10, 30, 80}) maps.push_back(EncodeMap(test::RandomStoredMap(steps, steps)));
  maps.push_back(EncodeMap(test::OfTwoCameras(5, 40)));
  return maps;
}

TEST(MapFileFuzz, DamagedFilesAreRefused) {
  const std::vector<ByteVector> maps = SmallMaps();
  test::Fuzz([&](Random& random) {
    ByteVector bytes = maps[random() % maps.size()];
    const ByteVector whole = bytes;
    Mutate(bytes, random);
    EXPECT_EQ(DecodesSoundly(bytes), bytes == whole);
    return bytes == whole;
  });
}

TEST(MapFileFuzz, DamagedContentWithValidChecksum) {
  const std::vector<ByteVector> maps = SmallMaps();
  test::Fuzz([&](Random& random) {
    ByteVector bytes = maps[random() % maps.size()];
    Mutate(bytes, random);
    test::Sign(bytes);
    return DecodesSoundly(bytes);
  });
}

TEST(MapFileFuzz, NoiseIsRefused) {
  test::Fuzz([](Random& random) {
    ByteVector bytes(random() % 3000);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
    if (random() % 2 == 0 && bytes.size() > 64) {
      std::memcpy(bytes.data(), "PLSLAMAP\1\0\0\0\0\0\0\0", 16);
      test::Sign(bytes);
    }
    return DecodesSoundly(bytes);
  });
}

}  // namespace
}  // namespace plslam
