// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <libdeflate.h>

#include <cstdint>
#include <string_view>

namespace plslam {

// The format of MCAP files (mcap.dev, version 0), as reader and writer share it.

/// The first and the last bytes of a file.
inline constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};

/// Kinds of records, as the format numbers them.
enum class McapRecord : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

/// Continues the checksum `crc` (0: of no bytes) by `n` bytes.
inline uint32_t McapCrc(uint32_t crc, const void* bytes, size_t n) { return libdeflate_crc32(crc, bytes, n); }

}  // namespace plslam
