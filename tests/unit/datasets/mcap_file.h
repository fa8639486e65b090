// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/unit/datasets/tiny_recording.h"

namespace plslam::test {

/// Return a record of this type; and a chunk that claims to have `n` bytes, decompressed (checksum 0: none).
std::string McapRecordBytes(uint8_t kind, const std::string& content);
std::string McapChunk(const std::string& compression, const std::string& packed, uint64_t n, uint32_t crc = 0);

/// A tiny valid recording of ROS 2 in MCAP: three frames of `TinyPixel`, 100 ms apart, a chunk each, camera_info, and
/// the pose (i, 0, 0) of frame i on /ground_truth.
void MakeMcapFile(const std::filesystem::path& path, const RecordingOptions& options = {});

}  // namespace plslam::test
