// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/mcap_reader.h"

#include <algorithm>
#include <cstring>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/datasets/recordings/mcap_format.h"
#include "core/errors/error_text.h"

namespace plslam {
namespace {

using Fields = RecordFields;

constexpr uint64_t kRecordHeadBytes = 9;  // kind and length
constexpr uint64_t kFooterBytes = kRecordHeadBytes + 8 + 8 + 4;
constexpr uint64_t kMaxSummaryBytes = 128 << 20;
constexpr uint64_t kUsualIndexBytes = 1024;

Fields ContentOf(std::span<const uint8_t> record, McapRecord kind, const char* what) {
  Fields fields(record);
  if (fields.Get<uint8_t>() != static_cast<uint8_t>(kind)) {
    throw DatasetError(fmt::format("{} is not at its position in the index: the file is damaged", what));
  }
  return Fields(fields.Take(fields.Get<uint64_t>()));
}

uint32_t Crc(std::span<const uint8_t> bytes) { return McapCrc(0, bytes.data(), bytes.size()); }

/// Channel, number, and the times of logging and of publishing, in front of the content of a message.
constexpr uint64_t kMessageHeadBytes = sizeof(uint16_t) + sizeof(uint32_t) + 2 * sizeof(uint64_t);

/// From the begin of a chunk that is not compressed to its messages: times, length, checksum and compression.
constexpr uint64_t kChunkHeadBytes = kRecordHeadBytes + 4 * sizeof(uint64_t) + 2 * sizeof(uint32_t);

/// Calls `take` for each record, with its kind and the offset at which it begins.
template <class Take>
void ForEachRecord(std::span<const uint8_t> bytes, Take take) {
  for (Fields records(bytes); !records.empty();) {
    const uint64_t at = bytes.size() - records.rest().size();
    const auto kind = static_cast<McapRecord>(records.Get<uint8_t>());
    take(kind, Fields(records.Take(records.Get<uint64_t>())), at);
  }
}

/// Returns the content of the message whose record begins at `offset`.
std::span<const uint8_t> ContentIn(std::span<const uint8_t> bytes, uint64_t offset) {
  if (offset > bytes.size()) throw DatasetError("a message would end after its chunk: the file is damaged");
  Fields fields = ContentOf(bytes.subspan(offset), McapRecord::kMessage, "a message");
  fields.Take(kMessageHeadBytes);
  return fields.rest();
}

/// Schemas and channels as the records name them.
class NamedChannels {
 public:
  /// Returns the number of bytes that are kept of it: 0 for one that is repeated.
  size_t Add(McapRecord kind, Fields fields) {
    const auto id = fields.Get<uint16_t>();
    if (kind == McapRecord::kSchema && !schemas_.contains(id)) return (schemas_[id] = fields.Text()).size();
    if (kind != McapRecord::kChannel || channels_.contains(id)) return 0;
    const auto schema = fields.Get<uint16_t>();
    const std::string topic = fields.Text(), encoding = fields.Text();
    channels_[id] = {schema, {id, topic, "", encoding}};
    return topic.size() + encoding.size();
  }

  static bool IsOne(McapRecord kind) { return kind == McapRecord::kSchema || kind == McapRecord::kChannel; }

  /// Schema 0 is that of channels without any.
  bool HasAllSchemas() const {
    return std::all_of(channels_.begin(), channels_.end(), [&](const auto& channel) {
      return channel.second.first == 0 || schemas_.contains(channel.second.first);
    });
  }

  /// In order of their ids.
  std::vector<RecordedChannel> List() const {
    std::vector<RecordedChannel> list;
    for (const auto& [id, channel] : channels_) {
      list.push_back(channel.second);
      const auto schema = schemas_.find(channel.first);
      if (schema != schemas_.end()) list.back().type = RosTypeName(schema->second);
    }
    return list;
  }

 private:
  std::map<uint16_t, std::string> schemas_;
  std::map<uint16_t, std::pair<uint16_t, RecordedChannel>> channels_;  // with their schemas
};

}  // namespace

McapReader::McapReader(const std::string& path, const std::string& why_scan) : file_(path) {
  CheckMagic();
  std::string why = why_scan;
  try {
    if (why.empty()) why = ReadSummary();
  } catch (const DatasetError& error) {
    why = error.what();
  }
  if (!why.empty()) Scan(why);
}

void McapReader::CheckMagic() const {
  const Bytes begin = file_.ReadAt(0, std::min<uint64_t>(file_.size(), kMcapMagic.size()), "the head");
  const std::string_view text(reinterpret_cast<const char*>(begin.data()), begin.size());
  if (text.empty()) throw DatasetError("is empty (0 bytes), not an MCAP file: record it again");
  if (text == kMcapMagic) return;
  throw DatasetError(
      fmt::format("is not an MCAP file, because it begins with '{}': give a file written by `ros2 bag record -s "
                  "mcap`, or its format (--kind)",
                  Shown(text)));
}

std::string McapReader::ReadSummary() {
  const uint64_t end_bytes = kFooterBytes + kMcapMagic.size();
  const char* const unclosed = "has no index, because its recorder did not close it or it is truncated";
  if (file_.size() < kMcapMagic.size() + end_bytes) return unclosed;
  const Bytes end = file_.ReadAt(file_.size() - end_bytes, end_bytes, "the footer");
  if (std::memcmp(end.data() + kFooterBytes, kMcapMagic.data(), kMcapMagic.size()) != 0) return unclosed;
  Fields footer = ContentOf(end, McapRecord::kFooter, "the footer");
  is_closed_ = true;
  const auto start = footer.Get<uint64_t>();
  footer.Get<uint64_t>();  // where the offsets of the summary begin
  const auto crc = footer.Get<uint32_t>();
  if (start == 0) return "has no index (no summary)";
  const uint64_t footer_at = file_.size() - end_bytes;
  if (start > footer_at || footer_at - start > kMaxSummaryBytes) {
    return fmt::format("its summary would begin at byte {} of {}", start, file_.size());
  }
  // The checksum is of the summary and of the footer before the checksum itself.
  const uint64_t n = footer_at - start;
  const Bytes summary = file_.ReadAt(start, n + kFooterBytes - sizeof(crc), "the summary");
  if (crc != 0 && crc != Crc(summary)) return "the checksum of its summary is wrong";
  return Parse(std::span(summary).first(n));
}

std::string McapReader::Parse(std::span<const uint8_t> summary) {
  NamedChannels named;
  ForEachRecord(summary, [&](McapRecord kind, Fields fields, uint64_t) {
    if (NamedChannels::IsOne(kind)) named.Add(kind, fields);
    if (kind == McapRecord::kStatistics) {
      is_empty_ = fields.Get<uint64_t>() == 0;
      fields.Take(sizeof(uint16_t) + 3 * sizeof(uint32_t));  // other numbers
      n_chunks_ = fields.Get<uint32_t>();
      fields.Take(2 * sizeof(uint64_t));  // first and last time
      for (Fields counts(fields.Take(fields.Get<uint32_t>())); !counts.empty();) {
        const auto channel = counts.Get<uint16_t>();
        n_messages_[channel] = counts.Get<uint64_t>();
      }
    }
    if (kind != McapRecord::kChunkIndex) return;
    Chunk chunk;
    fields.Take(2 * sizeof(uint64_t));  // first and last time
    chunk.offset = fields.Get<uint64_t>();
    chunk.length = fields.Get<uint64_t>();
    for (Fields offsets(fields.Take(fields.Get<uint32_t>())); !offsets.empty();) {
      const auto channel = offsets.Get<uint16_t>();
      chunk.indices[channel] = offsets.Get<uint64_t>();
    }
    fields.Take(sizeof(uint64_t));  // the length of its indices
    const std::string compression = fields.Text();
    fields.Take(sizeof(uint64_t));  // its length, compressed
    if (compression.empty()) chunk.data_at = chunk.offset + kChunkHeadBytes;
    chunk.cost = DecompressionCostOf(compression, fields.Get<uint64_t>());
    chunks_.push_back(std::move(chunk));
  });
  std::stable_sort(chunks_.begin(), chunks_.end(),
                   [](const Chunk& a, const Chunk& b) { return a.offset < b.offset; });
  channels_ = named.List();
  return WhatIsMissing(named.HasAllSchemas());
}

std::string McapReader::WhatIsMissing(bool all_schemas) const {
  if (chunks_.empty()) return is_empty_ ? "" : "has no index of chunks";
  if (n_chunks_.value_or(0) > chunks_.size()) {
    return fmt::format("has an index of {} chunks instead of {}", chunks_.size(), *n_chunks_);
  }
  std::set<uint32_t> ids;
  for (const RecordedChannel& channel : channels_) ids.insert(channel.id);
  for (const Chunk& chunk : chunks_) {
    if (chunk.indices.empty()) return "has no index of messages";
    const bool known = std::all_of(chunk.indices.begin(), chunk.indices.end(),
                                   [&](const auto& index) { return ids.contains(index.first); });
    if (!known || !all_schemas) return "has no index of all topics and types";
  }
  return {};
}

void McapReader::Scan(const std::string& why) {
  channels_.clear();
  chunks_.clear();
  NamedChannels named;
  const auto add = [&](Fields message, uint32_t chunk, uint64_t offset) {
    const auto channel = message.Get<uint16_t>();
    message.Get<uint32_t>();
    const int64_t t_ns = LogTime(message.Get<uint64_t>());
    message.Get<int64_t>();  // of publishing
    scanned_.Add(channel, {t_ns, StampOf(message.rest()), chunk, offset});
  };
  const auto end = [&](uint64_t at) {
    const Bytes head = file_.ReadAt(at, kRecordHeadBytes, "a record");
    if (head.front() == 0)
      throw DatasetError("a record has the invalid type 0");  // zeros, as a power cut leaves them
    return at + kRecordHeadBytes + Fields(std::span(head).subspan(1)).Get<uint64_t>();
  };
  const auto take = [&](uint64_t at, uint64_t record_end) {
    const auto kind = static_cast<McapRecord>(file_.ReadAt(at, 1, "a record").front());
    if (kind == McapRecord::kDataEnd || kind == McapRecord::kFooter) return false;
    if (NamedChannels::IsOne(kind) && record_end - at <= kMaxChunkBytes) {
      const Bytes record = file_.ReadAt(at, record_end - at, "a channel");
      scanned_.SpendKept(named.Add(kind, ContentOf(record, kind, "a channel")));
    } else if (kind == McapRecord::kMessage) {
      // Its content is read when it is played.
      const uint64_t head_bytes = kRecordHeadBytes + kMessageHeadBytes + kStampBytes;
      const Bytes head = file_.ReadAt(at, std::min(head_bytes, record_end - at), "a message");
      add(Fields(std::span(head).subspan(kRecordHeadBytes)), RecordedMessage::kNoChunk, at);
    } else if (kind == McapRecord::kChunk) {
      const Chunk chunk{at, record_end - at, {}};
      const Bytes bytes = Decompressed(chunk, &scanned_);
      const auto number = static_cast<uint32_t>(chunks_.size());
      chunks_.push_back(chunk);
      ForEachRecord(bytes, [&](McapRecord inner, Fields fields, uint64_t offset) {
        if (NamedChannels::IsOne(inner)) scanned_.SpendKept(named.Add(inner, fields));
        if (inner == McapRecord::kMessage) add(fields, number, offset);
      });
    }
    return true;
  };
  scanned_.Scan(file_, kMcapMagic.size(), {end, take}, why, "`mcap recover`");
  channels_ = named.List();
}

std::vector<RecordedMessage> McapReader::Messages(const std::string& topic) const {
  try {
    return scanned_.is_made() ? scanned_.Messages(topic, channels_) : IndexedMessages(topic);
  } catch (const DatasetError& error) {
    throw DamagedIndex(fmt::format("its index cannot be used ({})", error.what()));
  }
}

std::vector<RecordedMessage> McapReader::IndexedMessages(const std::string& topic) const {
  std::vector<RecordedMessage> messages;
  // The indices follow each chunk, close together.
  for (const Chunk& chunk : chunks_) file_.WillRead(chunk.offset + chunk.length, kUsualIndexBytes);
  uint64_t n_expected = 0;
  for (const RecordedChannel& channel : channels_) {
    const auto n = n_messages_.find(channel.id);
    if (channel.topic == topic && n != n_messages_.end()) n_expected += n->second;
  }
  for (uint32_t i = 0; i < chunks_.size(); ++i) {
    for (const RecordedChannel& channel : channels_) {
      if (channel.topic == topic) AppendMessages(i, channel, messages);
    }
  }
  if (messages.size() < n_expected) {
    throw DatasetError(fmt::format("it has {} of {} messages of {}", messages.size(), n_expected, topic));
  }
  SortByPlace(messages);
  return messages;
}

void McapReader::AppendMessages(uint32_t chunk, const RecordedChannel& channel,
                                std::vector<RecordedMessage>& messages) const {
  const auto at = chunks_[chunk].indices.find(channel.id);
  if (at == chunks_[chunk].indices.end()) return;
  const Bytes head = file_.ReadAt(at->second, kRecordHeadBytes, "an index of messages");
  uint64_t length = 0;
  std::memcpy(&length, head.data() + 1, sizeof(length));
  if (length > file_.size()) throw DatasetError("an index of messages is longer than the file: it is damaged");
  const Bytes record = file_.ReadAt(at->second, kRecordHeadBytes + length, "an index of messages");
  Fields fields = ContentOf(record, McapRecord::kMessageIndex, "an index of messages");
  if (fields.Get<uint16_t>() != channel.id) throw DatasetError("an index of messages is for another channel");
  for (Fields entries(fields.Take(fields.Get<uint32_t>())); !entries.empty();) {
    const int64_t t_ns = LogTime(entries.Get<uint64_t>());
    messages.push_back({t_ns, RecordedMessage::kNotRead, chunk, entries.Get<uint64_t>()});
  }
  // Many chunks of a damaged file may point to the same index, so the number of messages is bounded by the file's size.
  if (messages.size() > file_.size())
    throw DatasetError("its index has more messages than the file has bytes: it is damaged");
}

McapReader::Bytes McapReader::Decompressed(const Chunk& chunk, ScannedIndex* scan) const {
  CheckChunkSize(chunk.length);
  const Bytes record = file_.ReadAt(chunk.offset, chunk.length, "a chunk");
  Fields fields = ContentOf(record, McapRecord::kChunk, "a chunk");
  fields.Take(2 * sizeof(uint64_t));  // first and last time
  const auto n = fields.Get<uint64_t>();
  const auto crc = fields.Get<uint32_t>();
  const std::string compression = fields.Text();
  if (scan != nullptr) scan->SpendDecompressed(n);
  Bytes bytes = DecompressChunk(compression, fields.Take(fields.Get<uint64_t>()), n);
  if (crc != 0 && crc != Crc(bytes)) throw DatasetError("the checksum of a chunk is wrong: the file is damaged");
  return bytes;
}

std::optional<uint64_t> McapReader::PlaceInFile(const RecordedMessage& message) const {
  if (message.chunk == RecordedMessage::kNoChunk) return message.offset;
  const uint64_t data_at = chunks_.at(message.chunk).data_at;
  return data_at == 0 ? std::nullopt : std::optional(data_at + message.offset);
}

void McapReader::WillReadBegin(const RecordedMessage& message, uint64_t n) const {
  if (const auto at = PlaceInFile(message)) file_.WillRead(*at, kRecordHeadBytes + kMessageHeadBytes + n);
}

std::vector<uint8_t> McapReader::ReadBegin(const RecordedMessage& message, uint64_t n) const {
  const std::optional<uint64_t> at = PlaceInFile(message);
  if (!at) {
    return recent_.Copy(
        message.chunk, [&] { return Decompressed(chunks_.at(message.chunk)); },
        [&](const Bytes& bytes) {
          const auto content = ContentIn(bytes, message.offset);
          return content.first(std::min<uint64_t>(n, content.size()));
        });
  }
  const uint64_t head_bytes = kRecordHeadBytes + kMessageHeadBytes;
  const uint64_t left = *at < file_.size() ? file_.size() - *at : 0;
  const Bytes begin = file_.ReadAt(*at, std::min(head_bytes + n, std::max(left, head_bytes)), "a message");
  Fields fields(begin);
  if (fields.Get<uint8_t>() != static_cast<uint8_t>(McapRecord::kMessage)) {
    throw DatasetError("a message is not at its position in the index: the file is damaged");
  }
  const auto length = fields.Get<uint64_t>();
  fields.Take(kMessageHeadBytes);
  const uint64_t content_bytes = length - std::min(length, kMessageHeadBytes);
  const auto content = fields.Take(std::min({n, content_bytes, fields.rest().size()}));
  return {content.begin(), content.end()};
}

std::vector<uint8_t> McapReader::Read(const RecordedMessage& message) const {
  if (message.chunk == RecordedMessage::kNoChunk) {
    const Bytes head = file_.ReadAt(message.offset, kRecordHeadBytes, "a message");
    const auto n = Fields(std::span(head).subspan(1)).Get<uint64_t>();
    CheckChunkSize(n);
    const Bytes record = file_.ReadAt(message.offset, kRecordHeadBytes + n, "a message");
    const auto found = ContentIn(record, 0);
    return {found.begin(), found.end()};
  }
  return recent_.Copy(
      message.chunk, [&] { return Decompressed(chunks_.at(message.chunk)); },
      [&](const Bytes& bytes) { return ContentIn(bytes, message.offset); });
}

bool LooksLikeMcapFile(const std::string& path) { return BeginsWith(path, kMcapMagic); }

}  // namespace plslam
