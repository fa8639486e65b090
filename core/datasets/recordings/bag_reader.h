// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/datasets/recordings/chunks.h"
#include "core/datasets/recordings/recording.h"
#include "core/datasets/recordings/scanned_index.h"

namespace plslam {

/// A bag of ROS 1, format 2.0. Chunks may be as they are, or compressed by bz2 or lz4. The messages of a bag that was
/// not closed, or is cut off, are found by reading the whole file.
class BagReader : public Recording {
 public:
  /// A non-empty `why_scan` is the reason not to use the index (`DamagedIndex`).
  explicit BagReader(const std::string& path, const std::string& why_scan = "");

  const std::vector<RecordedChannel>& channels() const override { return channels_; }
  std::vector<RecordedMessage> Messages(const std::string& topic) const override;
  plslam::Notes Notes() const override { return scanned_.Notes(); }
  double scan_s() const override { return scanned_.taken_s(); }
  std::vector<uint8_t> Read(const RecordedMessage& message) const override;
  std::vector<uint8_t> ReadBegin(const RecordedMessage& message, uint64_t n) const override;
  void WillReadBegin(const RecordedMessage& message, uint64_t n) const override;
  uint64_t DecompressionCost(uint32_t chunk) const override;

 private:
  using Bytes = std::vector<uint8_t>;
  struct Chunk {
    uint64_t offset = 0, data_at = 0, data_bytes = 0;
    std::string compression;
    uint32_t size = 0;  ///< decompressed
    /// The indices of its messages extend from the end of the chunk to this offset.
    uint64_t indices_end = 0;
    std::vector<uint32_t> connections;  ///< with messages in it
  };

  struct Head {
    uint64_t end = 0;       ///< offset of the first record after it
    uint64_t index_at = 0;  ///< offset of the index; 0 if the bag was not closed
    bool is_empty = false;  ///< it was closed without messages
  };
  Head ReadHead() const;
  void ReadIndex(uint64_t at);
  /// Returns the number of bytes that are kept of it: 0 for one that is repeated.
  size_t AddConnection(uint32_t id, const std::string& topic, std::span<const uint8_t> data);
  void ListChannels();
  /// Without the connections.
  Chunk ReadChunkHead(uint64_t offset) const;
  void ReadChunkHeads(uint64_t index_at);
  void Scan(uint64_t from, const std::string& why);
  uint64_t RecordEnd(uint64_t at) const;
  /// The records from `from` on, as of that chunk.
  void ScanRecords(std::span<const uint8_t> bytes, uint32_t chunk, uint64_t from);
  Bytes Decompressed(const Chunk& chunk) const;
  std::vector<RecordedMessage> IndexedMessages(const std::string& topic) const;
  void AppendMessages(uint32_t chunk, uint32_t connection, std::vector<RecordedMessage>& messages) const;

  /// Returns the offset of a message in the file; nullopt if it is in a compressed chunk.
  std::optional<uint64_t> PlaceInFile(const RecordedMessage& message) const;

  RecordingFile file_;
  std::map<uint32_t, RecordedChannel> connections_;  ///< by id
  std::vector<RecordedChannel> channels_;
  std::vector<Chunk> chunks_;
  ScannedIndex scanned_;
  mutable RecentChunks recent_;
};

/// The file begins as bags do, of this version or another one.
bool LooksLikeBagFile(const std::string& path);

}  // namespace plslam
