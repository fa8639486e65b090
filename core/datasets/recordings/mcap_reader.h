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

/// An MCAP file (mcap.dev, version 0). Messages may stand in chunks or alone, and chunks may be as they are, or
/// compressed by lz4 or zstd; their checksums are compared. What its writer left out of the index, or did not come to
/// write, is found by reading the whole file.
class McapReader : public Recording {
 public:
  /// `why_scan`, where it is not empty: the index is not used, and why (`DamagedIndex`).
  explicit McapReader(const std::string& path, const std::string& why_scan = "");

  const std::vector<RecordedChannel>& channels() const override { return channels_; }
  std::vector<RecordedMessage> Messages(const std::string& topic) const override;
  std::vector<std::string> Notes() const override { return scanned_.Notes(); }
  double scan_s() const override { return scanned_.taken_s(); }
  std::vector<uint8_t> Read(const RecordedMessage& message) const override;

 private:
  using Bytes = std::vector<uint8_t>;
  struct Chunk {
    uint64_t offset = 0, length = 0;
    /// Where the index of each channel stands.
    std::map<uint32_t, uint64_t> indices;
  };

  void CheckMagic() const;
  /// All three return why the index cannot be used; empty where it can.
  std::string ReadSummary();
  std::string Parse(std::span<const uint8_t> summary);
  std::string WhatIsMissing(bool all_schemas) const;
  void Scan(const std::string& why);
  std::vector<RecordedMessage> IndexedMessages(const std::string& topic) const;
  void AppendMessages(uint32_t chunk, const RecordedChannel& channel, std::vector<RecordedMessage>& messages) const;
  /// `scan` is told of its size before.
  Bytes Decompressed(const Chunk& chunk, ScannedIndex* scan = nullptr) const;

  RecordingFile file_;
  std::vector<RecordedChannel> channels_;
  std::vector<Chunk> chunks_;
  /// What the summary says that there is, as far as it does.
  std::optional<uint32_t> n_chunks_;
  std::map<uint32_t, uint64_t> n_messages_;  ///< by channel
  ScannedIndex scanned_;
  mutable RecentChunks recent_;
};

/// The file begins as MCAP files do.
bool LooksLikeMcapFile(const std::string& path);

}  // namespace plslam
