// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace plslam {

/// A chunk of an MCAP file as it was before `compression`: "" (none), "lz4" (frames) or "zstd". `n` is its length
/// then, as the file says; one above 128 MB is refused. Throws DatasetError where the bytes are damaged or the
/// compression is another one.
std::vector<uint8_t> DecompressChunk(const std::string& compression, std::span<const uint8_t> bytes, uint64_t n);

/// A kind of messages in an MCAP file.
struct McapChannel {
  uint16_t id = 0;
  std::string topic;
  std::string type;      ///< name of its schema, "sensor_msgs/msg/Image"
  std::string encoding;  ///< of messages: "cdr"
};

/// Where a message stands.
struct McapMessage {
  int64_t t_ns = 0;     ///< when it was logged
  uint32_t chunk = 0;   ///< index of its chunk
  uint64_t offset = 0;  ///< in the chunk, decompressed
};

/// Reads an MCAP file (mcap.dev, version 0) through its index: opening reads the summary alone, `Messages` the
/// indices of one topic, and `Read` the chunk of a message. The chunks read last are kept, so memory does not grow
/// with the file. Chunks may be as they are, or compressed by lz4 or zstd; their checksums are compared.
///
/// Throws DatasetError, without the name of the file: where it is no MCAP file, is cut off, has no index, or is
/// damaged. May be used by several threads.
class McapReader {
 public:
  explicit McapReader(const std::string& path);
  ~McapReader();
  McapReader(const McapReader&) = delete;
  McapReader& operator=(const McapReader&) = delete;

  /// In order of their ids.
  const std::vector<McapChannel>& channels() const { return channels_; }

  /// All messages of the channels with this topic, in order of time.
  std::vector<McapMessage> Messages(const std::string& topic) const;

  /// The content of a message, a copy.
  std::vector<uint8_t> Read(const McapMessage& message) const;

 private:
  using Bytes = std::vector<uint8_t>;
  struct Chunk {
    uint64_t offset = 0, length = 0;
    /// Where the index of each channel stands.
    std::map<uint16_t, uint64_t> indices;
  };

  Bytes ReadAt(uint64_t offset, uint64_t n, const char* what) const;
  void ReadSummary();
  void Parse(std::span<const uint8_t> summary);
  Bytes Decompressed(const Chunk& chunk) const;
  const Bytes& ChunkBytes(uint32_t chunk) const;

  int fd_ = -1;
  uint64_t size_ = 0;
  std::vector<McapChannel> channels_;
  std::vector<Chunk> chunks_;
  mutable std::mutex mutex_;
  /// The one read last in front.
  mutable std::list<std::pair<uint32_t, Bytes>> recent_;
};

/// The file begins as MCAP files do.
bool LooksLikeMcapFile(const std::string& path);

}  // namespace plslam
