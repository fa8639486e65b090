// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

#include "core/io/files/dataset_error.h"

namespace plslam {

/// Reads a message of ROS 2: CDR (OMG DDS-XTypes, plain CDR), little endian, where numbers are aligned to their size,
/// counted behind the four bytes that name the encoding. Every read throws DatasetError where the message ends
/// before.
class CdrReader {
 public:
  explicit CdrReader(std::span<const uint8_t> message) : bytes_(message) {
    constexpr uint8_t kLittleEndian = 1;
    if (bytes_.size() < kHeadBytes || bytes_[0] != 0 || bytes_[1] != kLittleEndian) {
      throw DatasetError("the message is not plain CDR of little-endian machines");
    }
  }

  template <class Number>
  Number Get() {
    static_assert(std::is_arithmetic_v<Number>);
    const size_t from = (at_ - kHeadBytes) % sizeof(Number);
    if (from != 0) Skip(sizeof(Number) - from);
    Number value;
    std::memcpy(&value, Take(sizeof(Number)).data(), sizeof(Number));
    return value;
  }

  std::string Text() {
    const std::span<const uint8_t> bytes = Bytes();
    // The count includes the zero at the end.
    return {reinterpret_cast<const char*>(bytes.data()), bytes.empty() ? 0 : bytes.size() - 1};
  }

  /// A sequence of bytes, within the message.
  std::span<const uint8_t> Bytes() { return Take(Get<uint32_t>()); }

 private:
  static constexpr size_t kHeadBytes = 4;

  void Skip(size_t n) { Take(n); }
  std::span<const uint8_t> Take(size_t n) {
    if (n > bytes_.size() - at_) throw DatasetError("the message ends before its last field");
    at_ += n;
    return bytes_.subspan(at_ - n, n);
  }

  std::span<const uint8_t> bytes_;
  size_t at_ = kHeadBytes;
};

}  // namespace plslam
