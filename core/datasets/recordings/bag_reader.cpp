// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/bag_reader.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/errors/error_text.h"

namespace plslam {
namespace {

constexpr std::string_view kAnyMagic = "#ROSBAG V";
constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr uint64_t kMaxIndexBytes = 128 << 20;
/// Heads of chunks have about 60 bytes, and the head of the bag itself fills 4096.
constexpr uint64_t kMaxHeadBytes = 8192;
constexpr uint64_t kUsualHeadBytes = 128;

/// Kinds of records, as the format numbers them ("op").
enum class BagRecord : uint8_t {
  kMessage = 0x02,
  kBagHead = 0x03,
  kMessageIndex = 0x04,
  kChunk = 0x05,
  kChunkInfo = 0x06,
  kConnection = 0x07,
};

/// The named fields that every record begins with, and that a connection has once more in its data.
class NamedFields {
 public:
  explicit NamedFields(std::span<const uint8_t> bytes) {
    for (RecordFields fields(bytes); !fields.empty();) {
      const std::string field = fields.Text();
      const size_t sign = field.find('=');
      if (sign == std::string::npos) throw DatasetError("a field of a record has no name: the file is damaged");
      fields_[field.substr(0, sign)] = field.substr(sign + 1);
    }
  }

  template <class Number>
  Number Get(const char* name) const {
    const std::string text = Text(name);
    Number value{};
    if (text.size() != sizeof(value)) {
      throw DatasetError(fmt::format("the field '{}' of a record has {} bytes instead of {}: the file is damaged",
                                     name, text.size(), sizeof(value)));
    }
    std::memcpy(&value, text.data(), sizeof(value));
    return value;
  }
  std::string Text(const char* name) const {
    const auto field = fields_.find(name);
    if (field == fields_.end()) {
      throw DatasetError(fmt::format("a record has no field '{}': the file is damaged", name));
    }
    return field->second;
  }
  bool Has(const char* name) const { return fields_.contains(name); }
  BagRecord op() const { return static_cast<BagRecord>(Get<uint8_t>("op")); }

 private:
  std::map<std::string, std::string> fields_;
};

struct Record {
  NamedFields head;
  RecordFields data;
};

Record TakeRecord(RecordFields& bytes) {
  const auto head = bytes.Take(bytes.Get<uint32_t>());
  return {NamedFields(head), RecordFields(bytes.Take(bytes.Get<uint32_t>()))};
}

/// Returns the content of the message whose record begins at `offset`.
std::span<const uint8_t> ContentIn(std::span<const uint8_t> bytes, uint64_t offset) {
  if (offset > bytes.size()) throw DatasetError("a message would end after its chunk: the file is damaged");
  RecordFields records(bytes.subspan(offset));
  const Record record = TakeRecord(records);
  if (record.head.op() != BagRecord::kMessage) {
    throw DatasetError("a message is not at its position in the index: the file is damaged");
  }
  return record.data.rest();
}

/// Times of the format are seconds and nanoseconds, of 32 bits each.
int64_t GetTime_ns(RecordFields& fields) {
  const auto seconds = fields.Get<uint32_t>();
  return int64_t{seconds} * 1'000'000'000 + fields.Get<uint32_t>();
}

}  // namespace

BagReader::BagReader(const std::string& path, const std::string& why_scan) : file_(path) {
  const Head head = ReadHead();
  if (!why_scan.empty()) {
    Scan(head.end, why_scan);
  } else if (head.index_at == 0) {
    Scan(head.end, "has no index because it was not closed");
  } else if (head.is_empty && head.index_at == file_.size()) {
    return;
  } else if (head.index_at >= file_.size()) {
    Scan(head.end,
         fmt::format("its index would begin at byte {} of {}, so it is truncated", head.index_at, file_.size()));
  } else {
    try {
      ReadIndex(head.index_at);
      ReadChunkHeads(head.index_at);
    } catch (const DatasetError& error) {
      Scan(head.end, fmt::format("its index cannot be used ({})", error.what()));
    }
  }
}

BagReader::Head BagReader::ReadHead() const {
  const Bytes begin = file_.ReadAt(0, std::min<uint64_t>(file_.size(), kMaxHeadBytes), "the head");
  const std::string_view text(reinterpret_cast<const char*>(begin.data()), begin.size());
  if (text.empty()) throw DatasetError("is empty (0 bytes), not a ROS 1 bag: record it again");
  if (!text.starts_with(kMagic)) {
    const std::string shown = Shown(std::string(text.substr(0, std::min<size_t>(text.find('\n'), 20))));
    if (!text.starts_with(kAnyMagic)) {
      throw DatasetError(
          fmt::format("is not a ROS 1 bag, because it begins with '{}': give a file written by `rosbag record`, or "
                      "its format (--kind)",
                      shown));
    }
    throw DatasetError(
        fmt::format("begins with '{}', not with '#ROSBAG V2.0': convert it to 2.0 with `rosbag fix`", shown));
  }
  RecordFields bytes{std::span(begin).subspan(kMagic.size())};
  const NamedFields head(bytes.Take(bytes.Get<uint32_t>()));
  if (head.op() != BagRecord::kBagHead) throw DatasetError("does not begin with the header of a bag: it is damaged");
  if (head.Has("encryptor") && !head.Text("encryptor").empty()) {
    throw DatasetError("is encrypted: make it readable with `rosbag decrypt`");
  }
  bytes.Take(bytes.Get<uint32_t>());  // padding of the head
  const auto has_no = [&](const char* what) { return head.Has(what) && head.Get<uint32_t>(what) == 0; };
  const bool is_empty = has_no("conn_count") && has_no("chunk_count");
  return {begin.size() - bytes.rest().size(), head.Get<uint64_t>("index_pos"), is_empty};
}

void BagReader::ReadIndex(uint64_t at) {
  const uint64_t n = file_.size() - at;
  if (n > kMaxIndexBytes) throw DatasetError(fmt::format("its index would have {} bytes: the file is damaged", n));
  const Bytes index = file_.ReadAt(at, n, "the index");
  for (RecordFields records(index); !records.empty();) {
    Record record = TakeRecord(records);
    if (record.head.op() == BagRecord::kConnection) {
      AddConnection(record.head.Get<uint32_t>("conn"), record.head.Text("topic"), record.data.rest());
    } else if (record.head.op() == BagRecord::kChunkInfo) {
      Chunk chunk;
      chunk.offset = record.head.Get<uint64_t>("chunk_pos");
      while (!record.data.empty()) {
        chunk.connections.push_back(record.data.Get<uint32_t>());
        record.data.Get<uint32_t>();  // the number of messages
      }
      chunks_.push_back(std::move(chunk));
    }
  }
  ListChannels();
  const auto by_offset = [](const Chunk& a, const Chunk& b) { return a.offset < b.offset; };
  std::stable_sort(chunks_.begin(), chunks_.end(), by_offset);
}

size_t BagReader::AddConnection(uint32_t id, const std::string& topic, std::span<const uint8_t> data) {
  if (connections_.contains(id)) return 0;
  const std::string type = RosTypeName(NamedFields(data).Text("type"));
  connections_[id] = {id, topic, type, "ros1"};
  return sizeof(RecordedChannel) + topic.size() + type.size();
}

void BagReader::ListChannels() {
  for (const auto& [id, channel] : connections_) channels_.push_back(channel);
}

BagReader::Chunk BagReader::ReadChunkHead(uint64_t offset) const {
  if (offset >= file_.size()) throw DatasetError("a chunk would begin after the end of the file: it is damaged");
  const Bytes begin = file_.ReadAt(offset, std::min(kUsualHeadBytes, file_.size() - offset), "a chunk");
  RecordFields bytes(begin);
  const auto head_bytes = bytes.Get<uint32_t>();
  const NamedFields head(bytes.Take(head_bytes));
  if (head.op() != BagRecord::kChunk)
    throw DatasetError("a chunk is not at its position in the index: the file is damaged");
  Chunk chunk;
  chunk.offset = offset;
  chunk.compression = head.Text("compression");
  if (chunk.compression == "none") chunk.compression.clear();
  chunk.size = head.Get<uint32_t>("size");
  chunk.data_bytes = bytes.Get<uint32_t>();
  CheckChunkSize(std::max<uint64_t>(chunk.size, chunk.data_bytes));
  chunk.data_at = offset + head_bytes + 2 * sizeof(uint32_t);
  return chunk;
}

void BagReader::ReadChunkHeads(uint64_t index_at) {
  // Each chunk is preceded by the index of the previous one.
  constexpr uint64_t kUsualIndexBytes = 1024;
  for (const Chunk& chunk : chunks_) {
    const uint64_t before = std::min(chunk.offset, kUsualIndexBytes);
    file_.WillRead(chunk.offset - before, before + kUsualHeadBytes);
  }
  for (size_t i = 0; i < chunks_.size(); ++i) {
    Chunk chunk = ReadChunkHead(chunks_[i].offset);
    chunk.connections = std::move(chunks_[i].connections);
    chunk.indices_end = i + 1 < chunks_.size() ? chunks_[i + 1].offset : index_at;
    const uint64_t end = chunk.data_at + chunk.data_bytes;
    if (end > chunk.indices_end || chunk.indices_end - end > kMaxIndexBytes) {
      throw DatasetError("a chunk does not end before the next one: the file is damaged");
    }
    chunks_[i] = std::move(chunk);
  }
}

void BagReader::Scan(uint64_t from, const std::string& why) {
  channels_.clear();
  connections_.clear();
  chunks_.clear();
  const auto op_of = [&](uint64_t at, uint64_t end) {
    const Bytes begin = file_.ReadAt(at, std::min(end - at, kMaxHeadBytes), "a record");
    RecordFields fields(begin);
    return NamedFields(fields.Take(fields.Get<uint32_t>())).op();
  };
  const auto end_of = [&](uint64_t at) {
    const uint64_t end = RecordEnd(at);
    if (end <= file_.size()) op_of(at, end);  // zeros, as a power cut leaves them, are no record
    return end;
  };
  const auto take = [&](uint64_t at, uint64_t end) {
    const BagRecord op = op_of(at, end);
    if (op == BagRecord::kChunk) {
      const Chunk chunk = ReadChunkHead(at);
      scanned_.SpendDecompressed(chunk.size);
      const Bytes bytes = Decompressed(chunk);
      chunks_.push_back(chunk);
      ScanRecords(bytes, static_cast<uint32_t>(chunks_.size() - 1), 0);
    } else if (op == BagRecord::kMessage || op == BagRecord::kConnection) {
      // The last chunk of a bag that was not closed has no length yet, so that its records seem to be in none.
      CheckChunkSize(end - at);
      ScanRecords(file_.ReadAt(at, end - at, "a record"), RecordedMessage::kNoChunk, at);
    }
    return true;
  };
  scanned_.Scan(file_, from, {end_of, take}, why, "`rosbag reindex`");
  ListChannels();
}

uint64_t BagReader::RecordEnd(uint64_t at) const {
  for (int part = 0; part < 2; ++part) {  // head and data
    const Bytes length = file_.ReadAt(at, sizeof(uint32_t), "a record");
    at += sizeof(uint32_t) + RecordFields(length).Get<uint32_t>();
  }
  return at;
}

void BagReader::ScanRecords(std::span<const uint8_t> bytes, uint32_t chunk, uint64_t from) {
  for (RecordFields records(bytes); !records.empty();) {
    const uint64_t offset = from + bytes.size() - records.rest().size();
    const Record record = TakeRecord(records);
    if (record.head.op() == BagRecord::kConnection) {
      scanned_.SpendKept(
          AddConnection(record.head.Get<uint32_t>("conn"), record.head.Text("topic"), record.data.rest()));
    } else if (record.head.op() == BagRecord::kMessage) {
      const std::string time = record.head.Text("time");
      RecordFields fields{std::span(reinterpret_cast<const uint8_t*>(time.data()), time.size())};
      scanned_.Add(record.head.Get<uint32_t>("conn"),
                   {GetTime_ns(fields), StampOf(record.data.rest()), chunk, offset});
    }
  }
}

BagReader::Bytes BagReader::Decompressed(const Chunk& chunk) const {
  return DecompressChunk(chunk.compression, file_.ReadAt(chunk.data_at, chunk.data_bytes, "a chunk"), chunk.size);
}

void BagReader::AppendMessages(uint32_t chunk, uint32_t connection, std::vector<RecordedMessage>& messages) const {
  const uint64_t at = chunks_[chunk].data_at + chunks_[chunk].data_bytes;
  const Bytes indices = file_.ReadAt(at, chunks_[chunk].indices_end - at, "the indices of a chunk");
  for (RecordFields records(indices); !records.empty();) {
    Record record = TakeRecord(records);
    if (record.head.op() != BagRecord::kMessageIndex || record.head.Get<uint32_t>("conn") != connection) continue;
    while (!record.data.empty()) {
      const int64_t t_ns = GetTime_ns(record.data);
      messages.push_back({t_ns, RecordedMessage::kNotRead, chunk, record.data.Get<uint32_t>()});
    }
  }
}

std::vector<RecordedMessage> BagReader::Messages(const std::string& topic) const {
  try {
    return scanned_.is_made() ? scanned_.Messages(topic, channels_) : IndexedMessages(topic);
  } catch (const DatasetError& error) {
    throw DamagedIndex(fmt::format("its index cannot be used ({})", error.what()));
  }
}

std::vector<RecordedMessage> BagReader::IndexedMessages(const std::string& topic) const {
  std::vector<RecordedMessage> messages;
  for (uint32_t i = 0; i < chunks_.size(); ++i) {
    for (const RecordedChannel& channel : channels_) {
      const auto& present = chunks_[i].connections;
      if (channel.topic != topic || std::find(present.begin(), present.end(), channel.id) == present.end()) continue;
      AppendMessages(i, channel.id, messages);
    }
  }
  SortByPlace(messages);
  return messages;
}

std::optional<uint64_t> BagReader::PlaceInFile(const RecordedMessage& message) const {
  if (message.chunk == RecordedMessage::kNoChunk) return message.offset;
  const Chunk& chunk = chunks_.at(message.chunk);
  return chunk.compression.empty() ? std::optional(chunk.data_at + message.offset) : std::nullopt;
}

uint64_t BagReader::DecompressionCost(uint32_t chunk) const {
  return DecompressionCostOf(chunks_.at(chunk).compression, chunks_.at(chunk).size);
}

void BagReader::WillReadBegin(const RecordedMessage& message, uint64_t n) const {
  if (const auto at = PlaceInFile(message)) file_.WillRead(*at, kUsualHeadBytes + n);
}

std::vector<uint8_t> BagReader::ReadBegin(const RecordedMessage& message, uint64_t n) const {
  const std::optional<uint64_t> at = PlaceInFile(message);
  if (!at) {
    return recent_.Copy(
        message.chunk, [&] { return Decompressed(chunks_.at(message.chunk)); },
        [&](const Bytes& bytes) {
          const auto content = ContentIn(bytes, message.offset);
          return content.first(std::min<uint64_t>(n, content.size()));
        });
  }
  const uint64_t left = *at < file_.size() ? file_.size() - *at : 0;
  const Bytes begin = file_.ReadAt(*at, std::min(kUsualHeadBytes + n, left), "a message");
  RecordFields bytes(begin);
  if (NamedFields(bytes.Take(bytes.Get<uint32_t>())).op() != BagRecord::kMessage) {
    throw DatasetError("a message is not at its position in the index: the file is damaged");
  }
  const uint64_t content_bytes = bytes.Get<uint32_t>();
  const auto content = bytes.Take(std::min({n, content_bytes, uint64_t{bytes.rest().size()}}));
  return {content.begin(), content.end()};
}

std::vector<uint8_t> BagReader::Read(const RecordedMessage& message) const {
  if (message.chunk == RecordedMessage::kNoChunk) {
    const Bytes record = file_.ReadAt(message.offset, RecordEnd(message.offset) - message.offset, "a message");
    const auto found = ContentIn(record, 0);
    return {found.begin(), found.end()};
  }
  return recent_.Copy(
      message.chunk, [&] { return Decompressed(chunks_.at(message.chunk)); },
      [&](const Bytes& bytes) { return ContentIn(bytes, message.offset); });
}

bool LooksLikeBagFile(const std::string& path) { return BeginsWith(path, kAnyMagic); }

}  // namespace plslam
