// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/datasets/mcap_file.h"

#include <zlib.h>

#include <cstdint>
#include <map>
#include <vector>

#include "tests/unit/datasets/dataset_folders.h"

namespace plslam::test {
namespace {

uint32_t Crc(const std::string& bytes) {
  return static_cast<uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// Each channel has a separate schema.
std::string Channels(const RecordingOptions& o) {
  std::string records;
  const std::vector<TinyTopic> topics = TinyTopics(o);
  for (size_t i = 0; i < topics.size(); ++i) {
    const std::string type = topics[i].package + "/msg/" + topics[i].type;
    const auto id = static_cast<uint16_t>(i), schema = static_cast<uint16_t>(i + 1);
    records += McapRecordBytes(3, RecordBytes().Add(schema).Text(type).Text("ros2msg").Text("").bytes());
    records +=
        McapRecordBytes(4, RecordBytes().Add(id).Add(schema).Text(topics[i].topic).Text("cdr").Text("").bytes());
  }
  return records;
}

}  // namespace

std::string McapRecordBytes(uint8_t kind, const std::string& content) {
  return RecordBytes().Add(kind).Add(static_cast<uint64_t>(content.size())).Raw(content).bytes();
}

std::string McapChunk(const std::string& compression, const std::string& packed, uint64_t n, uint32_t crc) {
  RecordBytes content;
  content.Add(int64_t{0}).Add(int64_t{0}).Add(n).Add(crc);
  content.Text(compression).Add(static_cast<uint64_t>(packed.size())).Raw(packed);
  return McapRecordBytes(6, content.bytes());
}

void MakeMcapFile(const std::filesystem::path& path, const RecordingOptions& o) {
  const std::string magic("\x89MCAP0\r\n", 8);
  std::string file = magic + McapRecordBytes(1, RecordBytes().Text("ros2").Text("test").bytes());
  std::string chunk_indices;
  const std::vector<std::vector<TinyMessage>> chunks = TinyChunks(o, false);
  for (size_t i = 0; i < chunks.size(); ++i) {
    std::string chunk = i == 0 ? Channels(o) : "";
    std::map<uint16_t, RecordBytes> entries;
    for (const auto& [channel, log_ns, cdr] : chunks[i]) {
      entries[channel].Add(log_ns).Add(static_cast<uint64_t>(chunk.size()));
      chunk +=
          McapRecordBytes(5, RecordBytes().Add(channel).Add(uint32_t{0}).Add(log_ns).Add(log_ns).Raw(cdr).bytes());
    }
    const std::string packed = CompressedChunk(chunk, o.compression);
    const uint64_t chunk_at = file.size();
    const std::string record = McapChunk(o.compression, packed, chunk.size(), o.checksums ? Crc(chunk) : 0U);
    file += record;
    RecordBytes places;
    for (const auto& [channel, entry] : entries) {
      places.Add(channel).Add(static_cast<uint64_t>(file.size()));
      file += McapRecordBytes(7, RecordBytes().Add(channel).Text(entry.bytes()).bytes());
    }
    RecordBytes index;
    index.Add(int64_t{0})
        .Add(int64_t{0})
        .Add(chunk_at)
        .Add(static_cast<uint64_t>(record.size()))
        .Text(places.bytes());
    index.Add(uint64_t{0}).Text(o.compression).Add(static_cast<uint64_t>(packed.size()));
    index.Add(static_cast<uint64_t>(chunk.size()));
    if (static_cast<int>(i) < o.indexed_chunks) chunk_indices += McapRecordBytes(8, index.bytes());
  }
  file += McapRecordBytes(0x0f, RecordBytes().Add(uint32_t{0}).bytes());
  const uint64_t summary_at = file.size();
  const auto n_channels = static_cast<uint32_t>(TinyTopics(o).size());
  RecordBytes statistics, counts;
  std::map<uint16_t, uint64_t> n_messages;
  uint64_t n_all = 0;
  for (const std::vector<TinyMessage>& chunk : chunks) {
    for (const TinyMessage& message : chunk) ++n_messages[message.channel];
    n_all += chunk.size();
  }
  for (uint16_t id = 0; id < n_channels; ++id) counts.Add(id).Add(n_messages[id]);
  statistics.Add(n_all).Add(static_cast<uint16_t>(n_channels)).Add(n_channels);
  statistics.Add(0U)
      .Add(0U)
      .Add(static_cast<uint32_t>(chunks.size()))
      .Add(int64_t{0})
      .Add(int64_t{0})
      .Text(counts.bytes());
  const std::string summary = Channels(o) + McapRecordBytes(0x0b, statistics.bytes()) + chunk_indices;
  std::string footer = McapRecordBytes(2, RecordBytes().Add(summary_at).Add(uint64_t{0}).Add(uint32_t{0}).bytes());
  if (o.checksums) {
    footer.resize(footer.size() - 4);
    footer += RecordBytes().Add(Crc(summary + footer)).bytes();
  }
  WriteText(path, file + summary + footer + magic);
}

}  // namespace plslam::test
