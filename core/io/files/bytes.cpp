// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/files/bytes.h"

#include <cstdint>

namespace plslam {

std::string Base64(std::string_view bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text((bytes.size() + 2) / 3 * 4, '=');
  const auto byte = [&](size_t i) { return i < bytes.size() ? uint32_t{static_cast<uint8_t>(bytes[i])} : 0U; };
  char* out = text.data();
  size_t i = 0;
  for (; i + 3 <= bytes.size(); i += 3, out += 4) {
    const uint32_t three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    for (int digit = 0; digit < 4; ++digit) out[digit] = kDigits[three >> (18 - 6 * digit) & 63];
  }
  // One byte has two digits, two have three.
  const uint32_t rest = byte(i) << 16 | byte(i + 1) << 8;
  for (size_t digit = 0; i < bytes.size() && digit <= bytes.size() - i; ++digit) {
    out[digit] = kDigits[rest >> (18 - 6 * digit) & 63];
  }
  return text;
}

}  // namespace plslam
