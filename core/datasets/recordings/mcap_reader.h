// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/datasets/recordings/chunks.h"
#include "core/datasets/recordings/recording.h"

namespace plslam {

/// An MCAP file (mcap.dev, version 0). Chunks may be as they are, or compressed by lz4 or zstd; their checksums are
/// compared.
class McapReader : public Recording {
 public:
  explicit McapReader(const std::string& path);

  const std::vector<RecordedChannel>& channels() const override { return channels_; }
  std::vector<RecordedMessage> Messages(const std::string& topic) const override;
  std::vector<uint8_t> Read(const RecordedMessage& message) const override;

 private:
  using Bytes = std::vector<uint8_t>;
  struct Chunk {
    uint64_t offset = 0, length = 0;
    /// Where the index of each channel stands.
    std::map<uint32_t, uint64_t> indices;
  };

  void ReadSummary();
  void Parse(std::span<const uint8_t> summary);
  Bytes Decompressed(const Chunk& chunk) const;

  RecordingFile file_;
  std::vector<RecordedChannel> channels_;
  std::vector<Chunk> chunks_;
  mutable RecentChunks recent_;
};

/// The file begins as MCAP files do.
bool LooksLikeMcapFile(const std::string& path);

}  // namespace plslam
