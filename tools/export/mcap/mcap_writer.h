// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plslam::exports {

/// Writes an MCAP file (mcap.dev, version 0), profile `ros2`: chunks compressed by zstd, each with an index by channel,
/// and a summary with schemas, channels, chunk indices and statistics; all checksums are there. Memory grows only by
/// the index of each chunk of a megabyte.
///
/// The file is written under another name and renamed by Close; without Close it is removed. Throws std::runtime_error,
/// naming the file, if it cannot be written.
class McapWriter {
 public:
  explicit McapWriter(const std::string& path);
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// The number of a new channel. `type` is a ROS 2 name ("nav_msgs/msg/Path"), `definition` its text with all that
  /// it is made of.
  uint16_t AddChannel(const std::string& topic, const std::string& type, const std::string& definition);

  /// A message in CDR. Times should not decrease: readers go by the index otherwise, and are slower.
  void Write(uint16_t channel, int64_t t_ns, std::string_view cdr);

  void Close();

 private:
  struct Channel {
    std::string record;
    uint16_t schema = 0;
    uint32_t n_messages = 0;
    bool in_file = false;
  };
  struct ChunkIndex {
    uint64_t begin_ns = 0, end_ns = 0;
    uint64_t offset = 0, length = 0;
    uint64_t index_length = 0;
    uint64_t compressed = 0, uncompressed = 0;
    /// Offset in the file of each channel's index.
    std::map<uint16_t, uint64_t> channels;
  };
  using MessageIndex = std::vector<std::pair<uint64_t, uint64_t>>;

  void Append(std::string_view bytes);
  void FinishChunk();
  void WriteSummary();
  std::string StatisticsRecord() const;

  std::string path_;
  std::ofstream file_;
  uint64_t position_ = 0;
  uint32_t crc_ = 0;
  std::map<std::string, uint16_t> schemas_;
  std::vector<std::string> schema_records_;
  std::vector<Channel> channels_;
  std::string chunk_;
  uint64_t chunk_begin_ns_ = 0, chunk_end_ns_ = 0;
  std::map<uint16_t, MessageIndex> chunk_index_;
  std::vector<ChunkIndex> chunks_;
  uint64_t n_messages_ = 0;
  bool closed_ = false;
};

}  // namespace plslam::exports
