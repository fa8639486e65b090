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

/// An MCAP file (mcap.dev, version 0). Messages may be in chunks or outside, and chunks may be uncompressed, or
/// compressed by lz4 or zstd; their checksums are verified. If the index is incomplete or missing, the whole file is
/// read.
class McapReader : public Recording {
 public:
  /// A non-empty `why_scan` is the reason not to use the index (`DamagedIndex`).
  explicit McapReader(const std::string& path, const std::string& why_scan = "");

  const std::vector<RecordedChannel>& channels() const override { return channels_; }
  std::vector<RecordedMessage> Messages(const std::string& topic) const override;
  /// A file that was closed without messages is whole, and needs no index.
  plslam::Notes Notes() const override {
    return is_closed_ && !scanned_.has_messages() ? plslam::Notes{} : scanned_.Notes();
  }
  double scan_s() const override { return scanned_.taken_s(); }
  std::vector<uint8_t> Read(const RecordedMessage& message) const override;
  std::vector<uint8_t> ReadBegin(const RecordedMessage& message, uint64_t n) const override;
  void WillReadBegin(const RecordedMessage& message, uint64_t n) const override;
  uint64_t DecompressionCost(uint32_t chunk) const override { return chunks_.at(chunk).cost; }

 private:
  using Bytes = std::vector<uint8_t>;
  struct Chunk {
    uint64_t offset = 0, length = 0;
    /// Offset of the message index of each channel.
    std::map<uint32_t, uint64_t> indices;
    /// Offset of its messages if it is not compressed; 0 if that is not known.
    uint64_t data_at = 0;
    uint64_t cost = 0;  ///< of decompressing it
  };

  void CheckMagic() const;
  /// All three return the reason why the index cannot be used; empty if it can.
  std::string ReadSummary();
  std::string Parse(std::span<const uint8_t> summary);
  std::string WhatIsMissing(bool all_schemas) const;
  void Scan(const std::string& why);
  std::vector<RecordedMessage> IndexedMessages(const std::string& topic) const;
  void AppendMessages(uint32_t chunk, const RecordedChannel& channel, std::vector<RecordedMessage>& messages) const;
  /// `scan` receives its size first.
  Bytes Decompressed(const Chunk& chunk, ScannedIndex* scan = nullptr) const;

  /// Returns the offset of a message in the file; nullopt if it is in a compressed chunk.
  std::optional<uint64_t> PlaceInFile(const RecordedMessage& message) const;

  RecordingFile file_;
  bool is_closed_ = false;  ///< by its recorder
  std::vector<RecordedChannel> channels_;
  std::vector<Chunk> chunks_;
  /// Content of the file according to its summary, as far as that has it.
  bool is_empty_ = false;
  std::optional<uint32_t> n_chunks_;
  std::map<uint32_t, uint64_t> n_messages_;  ///< by channel
  ScannedIndex scanned_;
  mutable RecentChunks recent_;
};

/// The file begins as MCAP files do.
bool LooksLikeMcapFile(const std::string& path);

}  // namespace plslam
