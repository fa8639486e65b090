// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/bus/delivery/ordered_reader.h"
#include "core/bus/transport/wire.h"

namespace plslam::bus::test {

/// Nanoseconds.
inline constexpr int64_t kMs = 1'000'000;

/// `size` bytes that carry a number.
inline Bytes MessageOf(int64_t n, size_t size = 100) {
  std::vector<uint8_t> bytes(size, static_cast<uint8_t>(n));
  for (int i = 0; i < 8; ++i) bytes[static_cast<size_t>(i)] = static_cast<uint8_t>(n >> (8 * i));
  return std::make_shared<const std::vector<uint8_t>>(std::move(bytes));
}

inline int64_t NumberOf(const Bytes& message) {
  int64_t n = 0;
  for (int i = 7; i >= 0; --i) n = n << 8 | (*message)[static_cast<size_t>(i)];
  return n;
}

/// Returns the numbers of the messages that are in order so far.
inline std::vector<int64_t> Drain(OrderedReader& reader, int64_t now) {
  std::vector<int64_t> numbers;
  while (const Bytes front = reader.Front()) {
    numbers.push_back(NumberOf(front));
    reader.Pop(now);
  }
  return numbers;
}

}  // namespace plslam::bus::test
