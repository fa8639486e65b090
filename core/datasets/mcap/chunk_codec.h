// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace plslam {

/// A chunk of an MCAP file as it was before `compression`: "" (none), "lz4" (frames) or "zstd". `n` is its length
/// then, as the file says; one above 128 MB is refused. Throws DatasetError where the bytes are damaged or the
/// compression is another one.
std::vector<uint8_t> DecompressChunk(const std::string& compression, std::span<const uint8_t> bytes, uint64_t n);

}  // namespace plslam
