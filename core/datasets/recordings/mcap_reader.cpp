// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/mcap_reader.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

#include "core/datasets/recordings/mcap_format.h"

namespace plslam {
namespace {

using Fields = RecordFields;

constexpr uint64_t kRecordHeadBytes = 9;  // kind and length
constexpr uint64_t kFooterBytes = kRecordHeadBytes + 8 + 8 + 4;
constexpr uint64_t kMaxSummaryBytes = 128 << 20;

Fields ContentOf(std::span<const uint8_t> record, McapRecord kind, const char* what) {
  Fields fields(record);
  if (fields.Get<uint8_t>() != static_cast<uint8_t>(kind)) {
    throw DatasetError(fmt::format("{} is not where the index says: the file is damaged", what));
  }
  return Fields(fields.Take(fields.Get<uint64_t>()));
}

uint32_t Crc(std::span<const uint8_t> bytes) { return McapCrc(0, bytes.data(), bytes.size()); }

}  // namespace

McapReader::McapReader(const std::string& path) : file_(path) { ReadSummary(); }

void McapReader::ReadSummary() {
  const uint64_t end_bytes = kFooterBytes + kMcapMagic.size();
  if (file_.size() < kMcapMagic.size() + end_bytes) throw DatasetError("is too short for an MCAP file");
  const Bytes begin = file_.ReadAt(0, kMcapMagic.size(), "the head");
  if (std::memcmp(begin.data(), kMcapMagic.data(), kMcapMagic.size()) != 0) throw DatasetError("is no MCAP file");
  const Bytes end = file_.ReadAt(file_.size() - end_bytes, end_bytes, "the footer");
  if (std::memcmp(end.data() + kFooterBytes, kMcapMagic.data(), kMcapMagic.size()) != 0) {
    throw DatasetError("does not end as MCAP files do, since it is cut off: `mcap recover` makes it whole");
  }
  Fields footer = ContentOf(end, McapRecord::kFooter, "the footer");
  const auto start = footer.Get<uint64_t>();
  footer.Get<uint64_t>();  // where the offsets of the summary begin
  const auto crc = footer.Get<uint32_t>();
  if (start == 0) throw DatasetError("has no index (no summary): `mcap recover` writes one");
  const uint64_t footer_at = file_.size() - end_bytes;
  if (start > footer_at || footer_at - start > kMaxSummaryBytes) {
    throw DatasetError(
        fmt::format("its summary would begin at byte {} of {}: the file is damaged", start, file_.size()));
  }
  // The checksum is of the summary and of the footer before the checksum itself.
  const uint64_t n = footer_at - start;
  const Bytes summary = file_.ReadAt(start, n + kFooterBytes - sizeof(crc), "the summary");
  if (crc != 0 && crc != Crc(summary))
    throw DatasetError("the checksum of its summary is wrong: the file is damaged");
  Parse(std::span(summary).first(n));
}

void McapReader::Parse(std::span<const uint8_t> summary) {
  std::map<uint16_t, std::string> schemas;
  std::map<uint16_t, std::pair<uint16_t, RecordedChannel>> channels;  // with their schemas
  for (Fields records(summary); !records.empty();) {
    const auto kind = static_cast<McapRecord>(records.Get<uint8_t>());
    Fields fields(records.Take(records.Get<uint64_t>()));
    if (kind == McapRecord::kSchema) {
      const auto id = fields.Get<uint16_t>();
      schemas[id] = fields.Text();
    } else if (kind == McapRecord::kChannel) {
      const auto id = fields.Get<uint16_t>();
      const auto schema = fields.Get<uint16_t>();
      const std::string topic = fields.Text();
      channels[id] = {schema, {id, topic, "", fields.Text()}};
    } else if (kind == McapRecord::kChunkIndex) {
      Chunk chunk;
      fields.Take(2 * sizeof(uint64_t));  // first and last time
      chunk.offset = fields.Get<uint64_t>();
      chunk.length = fields.Get<uint64_t>();
      for (Fields offsets(fields.Take(fields.Get<uint32_t>())); !offsets.empty();) {
        const auto channel = offsets.Get<uint16_t>();
        chunk.indices[channel] = offsets.Get<uint64_t>();
      }
      chunks_.push_back(std::move(chunk));
    }
  }
  for (auto& [id, channel] : channels) {
    channel.second.type = RosTypeName(schemas[channel.first]);
    channels_.push_back(channel.second);
  }
}

std::vector<RecordedMessage> McapReader::Messages(const std::string& topic) const {
  std::vector<RecordedMessage> messages;
  for (uint32_t i = 0; i < chunks_.size(); ++i) {
    for (const RecordedChannel& channel : channels_) {
      const auto at = chunks_[i].indices.find(channel.id);
      if (channel.topic != topic || at == chunks_[i].indices.end()) continue;
      const Bytes head = file_.ReadAt(at->second, kRecordHeadBytes, "an index of messages");
      uint64_t length = 0;
      std::memcpy(&length, head.data() + 1, sizeof(length));
      if (length > file_.size()) throw DatasetError("an index of messages is longer than the file: it is damaged");
      const Bytes record = file_.ReadAt(at->second, kRecordHeadBytes + length, "an index of messages");
      Fields fields = ContentOf(record, McapRecord::kMessageIndex, "an index of messages");
      fields.Get<uint16_t>();
      for (Fields entries(fields.Take(fields.Get<uint32_t>())); !entries.empty();) {
        const auto t_ns = entries.Get<int64_t>();
        messages.push_back({t_ns, i, entries.Get<uint64_t>()});
      }
      // Of indices that many chunks name, memory is not for.
      if (messages.size() > file_.size())
        throw DatasetError("its index has more messages than the file has bytes: it is damaged");
    }
  }
  SortByTime(messages);
  return messages;
}

McapReader::Bytes McapReader::Decompressed(const Chunk& chunk) const {
  const Bytes record = file_.ReadAt(chunk.offset, chunk.length, "a chunk");
  Fields fields = ContentOf(record, McapRecord::kChunk, "a chunk");
  fields.Take(2 * sizeof(uint64_t));  // first and last time
  const auto n = fields.Get<uint64_t>();
  const auto crc = fields.Get<uint32_t>();
  const std::string compression = fields.Text();
  Bytes bytes = DecompressChunk(compression, fields.Take(fields.Get<uint64_t>()), n);
  if (crc != 0 && crc != Crc(bytes)) throw DatasetError("the checksum of a chunk is wrong: the file is damaged");
  return bytes;
}

std::vector<uint8_t> McapReader::Read(const RecordedMessage& message) const {
  return recent_.Copy(
      message.chunk, [&] { return Decompressed(chunks_.at(message.chunk)); },
      [&](const Bytes& bytes) {
        if (message.offset > bytes.size())
          throw DatasetError("a message would lie behind its chunk: the file is damaged");
        Fields fields = ContentOf(std::span(bytes).subspan(message.offset), McapRecord::kMessage, "a message");
        // Channel, number, and the times of logging and of publishing.
        fields.Take(sizeof(uint16_t) + sizeof(uint32_t) + 2 * sizeof(uint64_t));
        return fields.rest();
      });
}

bool LooksLikeMcapFile(const std::string& path) { return BeginsWith(path, kMcapMagic); }

}  // namespace plslam
