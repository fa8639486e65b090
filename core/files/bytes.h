// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstddef>
#include <cstring>
#include <exception>
#include <string>
#include <string_view>
#include <type_traits>

namespace plslam {

/// Returns whether the bytes could be appended; false if no memory is left. For callbacks of C libraries, which no
/// exception may pass through.
inline bool AppendBytes(std::string& file, const void* bytes, size_t n) noexcept {
  try {
    file.append(static_cast<const char*>(bytes), n);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

/// Appends the bytes of a number, lowest first.
template <class Number>
void AppendLittleEndian(Number number, std::string& bytes) {
  static_assert(std::is_arithmetic_v<Number>);
  static_assert(std::endian::native == std::endian::little, "other machines must turn the bytes round here");
  char raw[sizeof(Number)];
  std::memcpy(raw, &number, sizeof(Number));
  bytes.append(raw, sizeof(Number));
}

/// RFC 4648, with padding.
std::string Base64(std::string_view bytes);

}  // namespace plslam
