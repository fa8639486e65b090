// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstring>
#include <string>
#include <type_traits>

namespace plslam {

/// Appends the bytes of a number, lowest first.
template <class Number>
void AppendLittleEndian(Number number, std::string& bytes) {
  static_assert(std::is_arithmetic_v<Number>);
  static_assert(std::endian::native == std::endian::little, "other machines must turn the bytes round here");
  char raw[sizeof(Number)];
  std::memcpy(raw, &number, sizeof(Number));
  bytes.append(raw, sizeof(Number));
}

}  // namespace plslam
