// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/mcap/mcap_writer.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "core/datasets/recordings/mcap_format.h"
#include "core/errors/error_text.h"
#include "core/files/bytes.h"

namespace plslam::exports {
namespace {

/// Large enough for good compression, small enough that a reader reaches its first message at once.
constexpr size_t kChunkBytes = 1 << 20;
/// Half the time of zstd's default, and 5 % more bytes.
constexpr int kCompressionLevel = 1;

/// The fields of a record, one after the other without any alignment.
class Fields {
 public:
  template <class Number>
  Fields& Add(Number value) {
    AppendLittleEndian(value, bytes_);
    return *this;
  }
  /// Appends a text, or bytes with a length of four bytes.
  Fields& Add(std::string_view text) {
    Add(static_cast<uint32_t>(text.size()));
    bytes_.append(text);
    return *this;
  }
  /// Pairs of numbers: a map or an array of pairs, by the number of its bytes.
  template <class Pairs>
  Fields& AddPairs(const Pairs& pairs) {
    std::string content;
    for (const auto& [first, second] : pairs) {
      AppendLittleEndian(first, content);
      AppendLittleEndian(second, content);
    }
    return Add(std::string_view(content));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

std::string RecordBytes(McapRecord kind, std::string_view content) {
  std::string bytes;
  AppendLittleEndian(static_cast<uint8_t>(kind), bytes);
  AppendLittleEndian(static_cast<uint64_t>(content.size()), bytes);
  return bytes.append(content);
}

uint32_t Crc(uint32_t crc, std::string_view bytes) { return McapCrc(crc, bytes.data(), bytes.size()); }

std::string Compressed(std::string_view bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const size_t n = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kCompressionLevel);
  if (ZSTD_isError(n) != 0) throw std::runtime_error(fmt::format("zstd: {}", ZSTD_getErrorName(n)));
  out.resize(n);
  return out;
}

}  // namespace

McapWriter::McapWriter(const std::string& path) : path_(path), file_(path + ".part", std::ios::binary) {
  if (!file_) throw std::runtime_error(fmt::format("{}: cannot be written: {}", path, ReasonOf(errno)));
  Append(kMcapMagic);
  Append(RecordBytes(McapRecord::kHeader,
                     Fields().Add(std::string_view("ros2")).Add(std::string_view("plslam")).bytes()));
}

McapWriter::~McapWriter() {
  if (!closed_) std::remove((path_ + ".part").c_str());
}

void McapWriter::Append(std::string_view bytes) {
  if (!file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
    throw std::runtime_error(fmt::format("{}: cannot be written: {}", path_, ReasonOf(errno)));
  }
  position_ += bytes.size();
  crc_ = Crc(crc_, bytes);
}

uint16_t McapWriter::AddChannel(const std::string& topic, const std::string& type, const std::string& definition) {
  const auto [place, is_new] = schemas_.try_emplace(type, static_cast<uint16_t>(schemas_.size() + 1));
  if (is_new) {
    Fields schema;
    schema.Add(place->second).Add(std::string_view(type)).Add(std::string_view("ros2msg"));
    schema_records_.push_back(RecordBytes(McapRecord::kSchema, schema.Add(std::string_view(definition)).bytes()));
  }
  const auto id = static_cast<uint16_t>(channels_.size());
  Fields channel;
  channel.Add(id).Add(place->second).Add(std::string_view(topic)).Add(std::string_view("cdr"));
  channels_.push_back({RecordBytes(McapRecord::kChannel, channel.AddPairs(MessageIndex()).bytes()), place->second});
  return id;
}

void McapWriter::Write(uint16_t channel, int64_t t_ns, std::string_view cdr) {
  if (t_ns < 0)
    throw std::runtime_error(fmt::format("{}: MCAP has no times before 1970, such as {} ns", path_, t_ns));
  const auto time = static_cast<uint64_t>(t_ns);
  Channel& to = channels_.at(channel);
  // Written before the channel's first message, as required by readers that ignore the summary.
  if (!to.in_file) chunk_ += schema_records_[to.schema - 1U] + to.record;
  to.in_file = true;
  if (chunk_index_.empty()) chunk_begin_ns_ = chunk_end_ns_ = time;
  chunk_begin_ns_ = std::min(chunk_begin_ns_, time);
  chunk_end_ns_ = std::max(chunk_end_ns_, time);
  chunk_index_[channel].emplace_back(time, chunk_.size());
  Fields message;
  message.Add(channel).Add(to.n_messages++).Add(time).Add(time);
  AppendLittleEndian(static_cast<uint8_t>(McapRecord::kMessage), chunk_);
  AppendLittleEndian(static_cast<uint64_t>(message.bytes().size() + cdr.size()), chunk_);
  chunk_.append(message.bytes()).append(cdr);
  ++n_messages_;
  if (chunk_.size() >= kChunkBytes) FinishChunk();
}

void McapWriter::FinishChunk() {
  if (chunk_index_.empty()) return;
  const std::string compressed = Compressed(chunk_);
  Fields fields;
  fields.Add(chunk_begin_ns_).Add(chunk_end_ns_).Add(static_cast<uint64_t>(chunk_.size())).Add(Crc(0, chunk_));
  fields.Add(std::string_view("zstd")).Add(static_cast<uint64_t>(compressed.size()));
  const std::string record = RecordBytes(McapRecord::kChunk, fields.bytes() + compressed);
  ChunkIndex index{chunk_begin_ns_, chunk_end_ns_, position_, record.size(), 0, compressed.size(), chunk_.size(), {}};
  Append(record);
  const uint64_t begin = position_;
  for (auto& [channel, messages] : chunk_index_) {
    index.channels[channel] = position_;
    std::stable_sort(messages.begin(), messages.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    Append(RecordBytes(McapRecord::kMessageIndex, Fields().Add(channel).AddPairs(messages).bytes()));
  }
  index.index_length = position_ - begin;
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_index_.clear();
}

std::string McapWriter::StatisticsRecord() const {
  uint64_t begin = chunks_.empty() ? 0 : std::numeric_limits<uint64_t>::max(), end = 0;
  for (const ChunkIndex& chunk : chunks_) {
    begin = std::min(begin, chunk.begin_ns);
    end = std::max(end, chunk.end_ns);
  }
  std::map<uint16_t, uint64_t> counts;
  for (size_t i = 0; i < channels_.size(); ++i) {
    if (channels_[i].n_messages > 0) counts[static_cast<uint16_t>(i)] = channels_[i].n_messages;
  }
  Fields fields;
  fields.Add(n_messages_).Add(static_cast<uint16_t>(schema_records_.size()));
  fields.Add(static_cast<uint32_t>(channels_.size())).Add(uint32_t{0}).Add(uint32_t{0});
  fields.Add(static_cast<uint32_t>(chunks_.size())).Add(begin).Add(end).AddPairs(counts);
  return RecordBytes(McapRecord::kStatistics, fields.bytes());
}

void McapWriter::WriteSummary() {
  const uint64_t summary_start = position_;
  crc_ = 0;
  std::string offsets;
  const auto group = [&](McapRecord kind, uint64_t start) {
    if (position_ == start) return;
    Fields fields;
    fields.Add(static_cast<uint8_t>(kind)).Add(start).Add(position_ - start);
    offsets += RecordBytes(McapRecord::kSummaryOffset, fields.bytes());
  };
  uint64_t start = position_;
  for (const std::string& record : schema_records_) Append(record);
  group(McapRecord::kSchema, start);
  start = position_;
  for (const Channel& channel : channels_) Append(channel.record);
  group(McapRecord::kChannel, start);
  start = position_;
  for (const ChunkIndex& c : chunks_) {
    Fields fields;
    fields.Add(c.begin_ns).Add(c.end_ns).Add(c.offset).Add(c.length).AddPairs(c.channels).Add(c.index_length);
    fields.Add(std::string_view("zstd")).Add(c.compressed).Add(c.uncompressed);
    Append(RecordBytes(McapRecord::kChunkIndex, fields.bytes()));
  }
  group(McapRecord::kChunkIndex, start);
  start = position_;
  Append(StatisticsRecord());
  group(McapRecord::kStatistics, start);
  const uint64_t offset_start = position_;
  Append(offsets);
  // The checksum is of the summary and of the footer before the checksum itself.
  std::string footer =
      RecordBytes(McapRecord::kFooter, Fields().Add(summary_start).Add(offset_start).Add(uint32_t{0}).bytes());
  footer.resize(footer.size() - sizeof(uint32_t));
  const uint32_t crc = Crc(crc_, footer);
  AppendLittleEndian(crc, footer);
  Append(footer);
}

void McapWriter::Close() {
  FinishChunk();
  Append(RecordBytes(McapRecord::kDataEnd, Fields().Add(crc_).bytes()));
  WriteSummary();
  Append(kMcapMagic);
  file_.close();
  const std::string part = path_ + ".part";
  if (!file_ || std::rename(part.c_str(), path_.c_str()) != 0) {
    throw std::runtime_error(fmt::format("{}: cannot be written: {}", path_, ReasonOf(errno)));
  }
  closed_ = true;
}

}  // namespace plslam::exports
