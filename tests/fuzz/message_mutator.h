// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace plslam::test {

/// Flipped, set, inserted and removed bytes, extreme words, and truncation. The fingerprint mostly stays.
inline void Mutate(std::vector<uint8_t>& bytes, std::mt19937_64& random) {
  for (uint64_t n = random() % 6; n > 0 && bytes.size() > 8; --n) {
    const size_t from = random() % 16 == 0 ? 0 : 8;
    const size_t at = from + random() % (bytes.size() - from);
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    switch (random() % 6) {
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
      case 4:
        for (size_t i = at; i < std::min(at + 4, bytes.size()); ++i) bytes[i] = random() % 2 == 0 ? 0xFF : 0x7F;
        break;
      default:
        if (random() % 4 == 0) bytes.resize(at);
    }
  }
}

}  // namespace plslam::test
