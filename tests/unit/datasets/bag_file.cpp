// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/datasets/bag_file.h"

#include <fmt/format.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/datasets/dataset_folders.h"

namespace plslam::test {
namespace {

/// Named fields, each with its length.
std::string Fields(const std::vector<std::pair<std::string, std::string>>& fields) {
  RecordBytes bytes;
  for (const auto& [name, value] : fields) bytes.Text(fmt::format("{}={}", name, value));
  return bytes.bytes();
}

template <class Number>
std::string Value(Number value) {
  return RecordBytes().Add(value).bytes();
}

std::string Record(char op, std::vector<std::pair<std::string, std::string>> fields, const std::string& data) {
  fields.emplace_back("op", std::string(1, op));
  return RecordBytes().Text(Fields(fields)).Text(data).bytes();
}

std::string Time(int64_t t_ns) {
  return RecordBytes()
      .Add(static_cast<uint32_t>(t_ns / 1'000'000'000))
      .Add(static_cast<uint32_t>(t_ns % 1'000'000'000))
      .bytes();
}

std::string Connection(uint32_t id, const TinyTopic& topic) {
  return Record(7, {{"conn", Value(id)}, {"topic", topic.topic}},
                Fields({{"topic", topic.topic}, {"type", topic.package + "/" + topic.type}, {"md5sum", "*"}}));
}

std::string Head(uint64_t index_at, uint32_t n_connections, uint32_t n_chunks) {
  constexpr size_t kHeadBytes = 4096;
  const std::string fields = Fields({{"op", "\3"},
                                     {"index_pos", Value(index_at)},
                                     {"conn_count", Value(n_connections)},
                                     {"chunk_count", Value(n_chunks)}});
  return RecordBytes().Text(fields).Text(std::string(kHeadBytes - fields.size() - 8, ' ')).bytes();
}

}  // namespace

void MakeBagFile(const std::filesystem::path& path, const RecordingOptions& o) {
  const std::string magic = "#ROSBAG V2.0\n";
  std::string file = magic + Head(0, 0, 0);
  std::string chunk_infos;
  // A connection is recorded with its first message.
  const std::vector<TinyTopic> topics = o.n_frames == 0 ? std::vector<TinyTopic>{} : TinyTopics(o);
  const std::vector<std::vector<TinyMessage>> chunks = TinyChunks(o, true);
  for (size_t i = 0; i < chunks.size(); ++i) {
    std::string chunk, indices, counts;
    for (uint32_t id = 0; i == 0 && id < topics.size(); ++id) chunk += Connection(id, topics[id]);
    for (const auto& [channel, log_ns, message] : chunks[i]) {
      const uint32_t id = channel;
      indices += Record(4, {{"ver", Value(1U)}, {"conn", Value(id)}, {"count", Value(1U)}},
                        Time(log_ns) + Value(static_cast<uint32_t>(chunk.size())));
      chunk += Record(2, {{"conn", Value(id)}, {"time", Time(log_ns)}}, message);
      counts += Value(id) + Value(1U);
    }
    chunk_infos += Record(6,
                          {{"ver", Value(1U)},
                           {"chunk_pos", Value(static_cast<uint64_t>(file.size()))},
                           {"start_time", Time(0)},
                           {"end_time", Time(0)},
                           {"count", Value(static_cast<uint32_t>(chunks[i].size()))}},
                          counts);
    file += Record(5,
                   {{"compression", o.compression.empty() ? "none" : o.compression},
                    {"size", Value(static_cast<uint32_t>(chunk.size()))}},
                   CompressedChunk(chunk, o.compression));
    file += indices;
  }
  const std::string head =
      Head(file.size(), static_cast<uint32_t>(topics.size()), static_cast<uint32_t>(chunks.size()));
  file.replace(magic.size(), head.size(), head);
  for (uint32_t id = 0; id < topics.size(); ++id) file += Connection(id, topics[id]);
  WriteText(path, file + chunk_infos);
}

}  // namespace plslam::test
