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

/// A bag of ROS 1, format 2.0. Chunks may be as they are, or compressed by bz2 or lz4. A bag that was not closed has no
/// index and is refused.
class BagReader : public Recording {
 public:
  explicit BagReader(const std::string& path);

  const std::vector<RecordedChannel>& channels() const override { return channels_; }
  std::vector<RecordedMessage> Messages(const std::string& topic) const override;
  std::vector<uint8_t> Read(const RecordedMessage& message) const override;

 private:
  using Bytes = std::vector<uint8_t>;
  struct Chunk {
    uint64_t offset = 0, data_at = 0, data_bytes = 0;
    std::string compression;
    uint32_t size = 0;  ///< decompressed
    /// The indices of its messages stand from the end of the chunk until here.
    uint64_t indices_end = 0;
    std::vector<uint32_t> connections;  ///< that have messages in it
  };

  /// Returns where the index begins.
  uint64_t ReadHead() const;
  void ReadIndex(uint64_t at);
  void ReadChunkHeads(uint64_t index_at);
  void AppendMessages(uint32_t chunk, uint32_t connection, std::vector<RecordedMessage>& messages) const;

  RecordingFile file_;
  std::vector<RecordedChannel> channels_;
  std::vector<Chunk> chunks_;
  mutable RecentChunks recent_;
};

/// The file begins as bags do, of this version or another one.
bool LooksLikeBagFile(const std::string& path);

}  // namespace plslam
