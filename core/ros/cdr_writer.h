// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/files/bytes.h"

namespace plslam {

/// A message of ROS 2 as serialised by its middleware: CDR (OMG DDS-XTypes, plain CDR), little endian. Numbers are
/// aligned to their size, counted from after the four bytes that name the encoding; members follow each other without
/// other bytes in between.
class CdrWriter {
 public:
  template <class Number>
  void Put(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    const size_t from = (bytes_.size() - kHeadBytes) % sizeof(Number);
    if (from != 0) bytes_.append(sizeof(Number) - from, '\0');
    AppendLittleEndian(value, bytes_);
  }

  void Put(std::string_view text) {
    Put(static_cast<uint32_t>(text.size() + 1));
    bytes_.append(text).push_back('\0');
  }
  void Put(const char* text) { Put(std::string_view(text)); }

  /// Appends the number of elements before a sequence.
  void PutCount(size_t n) { Put(static_cast<uint32_t>(n)); }

  /// A sequence of bytes.
  void PutBytes(std::string_view bytes) {
    PutCount(bytes.size());
    bytes_.append(bytes);
  }

  std::string Take() && { return std::move(bytes_); }

 private:
  static constexpr size_t kHeadBytes = 4;

  std::string bytes_{"\0\1\0\0", kHeadBytes};
};

}  // namespace plslam
