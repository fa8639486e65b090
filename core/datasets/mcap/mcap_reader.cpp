// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/mcap/mcap_reader.h"

#include <fcntl.h>
#include <unistd.h>

#include <sys/stat.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <string_view>

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include "core/datasets/mcap/mcap_format.h"
#include "core/errors/error_text.h"
#include "core/io/files/dataset_error.h"

namespace plslam {
namespace {

constexpr uint64_t kMaxChunkBytes = 128 << 20;

[[noreturn]] void FailAsDamaged(const char* compression, const char* why) {
  throw DatasetError(fmt::format("a chunk is damaged: {} says '{}'", compression, why));
}

uint64_t Unzstd(std::span<const uint8_t> in, std::vector<uint8_t>& out) {
  const size_t n = ZSTD_decompress(out.data(), out.size(), in.data(), in.size());
  if (ZSTD_isError(n) != 0) FailAsDamaged("zstd", ZSTD_getErrorName(n));
  return n;
}

uint64_t Unlz4(std::span<const uint8_t> in, std::vector<uint8_t>& out) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0U) FailAsDamaged("lz4", "no memory");
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(made,
                                                                                     LZ4F_freeDecompressionContext);
  size_t in_done = 0, out_done = 0;
  while (in_done < in.size()) {
    size_t in_bytes = in.size() - in_done, out_bytes = out.size() - out_done;
    const size_t result =
        LZ4F_decompress(context.get(), out.data() + out_done, &out_bytes, in.data() + in_done, &in_bytes, nullptr);
    if (LZ4F_isError(result) != 0U) FailAsDamaged("lz4", LZ4F_getErrorName(result));
    in_done += in_bytes;
    out_done += out_bytes;
    if (in_bytes == 0 && out_bytes == 0) FailAsDamaged("lz4", "more bytes than the chunk should have");
  }
  return out_done;
}

}  // namespace

std::vector<uint8_t> DecompressChunk(const std::string& compression, std::span<const uint8_t> bytes, uint64_t n) {
  if (n > kMaxChunkBytes) {
    throw DatasetError(
        fmt::format("a chunk of {} bytes, more than {}: `mcap compress` writes smaller ones", n, kMaxChunkBytes));
  }
  if (compression.empty()) {
    if (n != bytes.size()) FailAsDamaged("the file", "another length");
    return {bytes.begin(), bytes.end()};
  }
  if (compression != "lz4" && compression != "zstd") {
    throw DatasetError(fmt::format("its chunks are compressed by '{}', not by lz4 or zstd", Shown(compression)));
  }
  auto out = WithMemoryFor(fmt::format("a chunk of {} bytes", n), [&] { return std::vector<uint8_t>(n); });
  const uint64_t got = compression == "lz4" ? Unlz4(bytes, out) : Unzstd(bytes, out);
  if (got != n) FailAsDamaged(compression.c_str(), "another length");
  return out;
}

namespace {

constexpr uint64_t kRecordHeadBytes = 9;  // kind and length
constexpr uint64_t kFooterBytes = kRecordHeadBytes + 8 + 8 + 4;
constexpr uint64_t kMaxSummaryBytes = 128 << 20;
/// Left and right image, their truth, and the neighbours of all: each may stand in another chunk.
constexpr size_t kChunksKept = 4;

/// Fields of a record, one after the other without any alignment.
class Fields {
 public:
  explicit Fields(std::span<const uint8_t> bytes) : rest_(bytes) {}

  template <class Number>
  Number Get() {
    Number value;
    std::memcpy(&value, Take(sizeof(Number)).data(), sizeof(Number));
    return value;
  }
  std::string Text() {
    const auto bytes = Take(Get<uint32_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  std::span<const uint8_t> Take(uint64_t n) {
    if (n > rest_.size()) throw DatasetError("a record ends before its last field: the file is damaged");
    const auto taken = rest_.first(n);
    rest_ = rest_.subspan(n);
    return taken;
  }
  bool empty() const { return rest_.empty(); }
  std::span<const uint8_t> rest() const { return rest_; }

 private:
  std::span<const uint8_t> rest_;
};

Fields ContentOf(std::span<const uint8_t> record, McapRecord kind, const char* what) {
  Fields fields(record);
  if (fields.Get<uint8_t>() != static_cast<uint8_t>(kind)) {
    throw DatasetError(fmt::format("{} is not where the index says: the file is damaged", what));
  }
  return Fields(fields.Take(fields.Get<uint64_t>()));
}

uint32_t Crc(std::span<const uint8_t> bytes) { return McapCrc(0, bytes.data(), bytes.size()); }

}  // namespace

McapReader::McapReader(const std::string& path) : fd_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  struct stat status {};
  if (fd_ < 0 || fstat(fd_, &status) != 0) throw DatasetError(fmt::format("cannot be read: {}", ReasonOf(errno)));
  size_ = static_cast<uint64_t>(status.st_size);
  try {
    ReadSummary();
  } catch (...) {
    close(fd_);
    throw;
  }
}

McapReader::~McapReader() { close(fd_); }

McapReader::Bytes McapReader::ReadAt(uint64_t offset, uint64_t n, const char* what) const {
  if (offset > size_ || n > size_ - offset) {
    throw DatasetError(fmt::format("{} would lie behind the end of the file: it is damaged or cut off", what));
  }
  Bytes bytes = WithMemoryFor(fmt::format("{} of {} bytes", what, n), [&] { return Bytes(n); });
  for (uint64_t done = 0; done < n;) {
    const ssize_t got = pread(fd_, bytes.data() + done, n - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw DatasetError(fmt::format("{} cannot be read: {}", what, ReasonOf(got < 0 ? errno : EIO)));
    done += static_cast<uint64_t>(got);
  }
  return bytes;
}

void McapReader::ReadSummary() {
  const uint64_t end_bytes = kFooterBytes + kMcapMagic.size();
  if (size_ < kMcapMagic.size() + end_bytes) throw DatasetError("is too short for an MCAP file");
  const Bytes begin = ReadAt(0, kMcapMagic.size(), "the head");
  if (std::memcmp(begin.data(), kMcapMagic.data(), kMcapMagic.size()) != 0) throw DatasetError("is no MCAP file");
  const Bytes end = ReadAt(size_ - end_bytes, end_bytes, "the footer");
  if (std::memcmp(end.data() + kFooterBytes, kMcapMagic.data(), kMcapMagic.size()) != 0) {
    throw DatasetError("does not end as MCAP files do, since it is cut off: `mcap recover` makes it whole");
  }
  Fields footer = ContentOf(end, McapRecord::kFooter, "the footer");
  const auto start = footer.Get<uint64_t>();
  footer.Get<uint64_t>();  // where the offsets of the summary begin
  const auto crc = footer.Get<uint32_t>();
  if (start == 0) throw DatasetError("has no index (no summary): `mcap recover` writes one");
  const uint64_t footer_at = size_ - end_bytes;
  if (start > footer_at || footer_at - start > kMaxSummaryBytes) {
    throw DatasetError(fmt::format("its summary would begin at byte {} of {}: the file is damaged", start, size_));
  }
  // The checksum is of the summary and of the footer before the checksum itself.
  const uint64_t n = footer_at - start;
  const Bytes summary = ReadAt(start, n + kFooterBytes - sizeof(crc), "the summary");
  if (crc != 0 && crc != Crc(summary))
    throw DatasetError("the checksum of its summary is wrong: the file is damaged");
  Parse(std::span(summary).first(n));
}

void McapReader::Parse(std::span<const uint8_t> summary) {
  std::map<uint16_t, std::string> schemas;
  std::map<uint16_t, std::pair<uint16_t, McapChannel>> channels;  // with their schemas
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
    channel.second.type = schemas[channel.first];
    channels_.push_back(channel.second);
  }
}

std::vector<McapMessage> McapReader::Messages(const std::string& topic) const {
  std::vector<McapMessage> messages;
  for (uint32_t i = 0; i < chunks_.size(); ++i) {
    for (const McapChannel& channel : channels_) {
      const auto at = chunks_[i].indices.find(channel.id);
      if (channel.topic != topic || at == chunks_[i].indices.end()) continue;
      const Bytes head = ReadAt(at->second, kRecordHeadBytes, "an index of messages");
      uint64_t length = 0;
      std::memcpy(&length, head.data() + 1, sizeof(length));
      if (length > size_) throw DatasetError("an index of messages is longer than the file: it is damaged");
      const Bytes record = ReadAt(at->second, kRecordHeadBytes + length, "an index of messages");
      Fields fields = ContentOf(record, McapRecord::kMessageIndex, "an index of messages");
      fields.Get<uint16_t>();
      for (Fields entries(fields.Take(fields.Get<uint32_t>())); !entries.empty();) {
        const auto t_ns = entries.Get<int64_t>();
        messages.push_back({t_ns, i, entries.Get<uint64_t>()});
      }
    }
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const McapMessage& a, const McapMessage& b) { return a.t_ns < b.t_ns; });
  return messages;
}

McapReader::Bytes McapReader::Decompressed(const Chunk& chunk) const {
  const Bytes record = ReadAt(chunk.offset, chunk.length, "a chunk");
  Fields fields = ContentOf(record, McapRecord::kChunk, "a chunk");
  fields.Take(2 * sizeof(uint64_t));  // first and last time
  const auto n = fields.Get<uint64_t>();
  const auto crc = fields.Get<uint32_t>();
  const std::string compression = fields.Text();
  Bytes bytes = DecompressChunk(compression, fields.Take(fields.Get<uint64_t>()), n);
  if (crc != 0 && crc != Crc(bytes)) throw DatasetError("the checksum of a chunk is wrong: the file is damaged");
  return bytes;
}

const McapReader::Bytes& McapReader::ChunkBytes(uint32_t chunk) const {
  const auto known =
      std::find_if(recent_.begin(), recent_.end(), [&](const auto& recent) { return recent.first == chunk; });
  if (known != recent_.end()) {
    recent_.splice(recent_.begin(), recent_, known);
  } else {
    if (recent_.size() == kChunksKept) recent_.pop_back();
    recent_.emplace_front(chunk, Decompressed(chunks_.at(chunk)));
  }
  return recent_.front().second;
}

std::vector<uint8_t> McapReader::Read(const McapMessage& message) const {
  const std::scoped_lock lock(mutex_);
  const Bytes& bytes = ChunkBytes(message.chunk);
  if (message.offset > bytes.size()) throw DatasetError("a message would lie behind its chunk: the file is damaged");
  Fields fields = ContentOf(std::span(bytes).subspan(message.offset), McapRecord::kMessage, "a message");
  // Channel, number, and the times of logging and of publishing.
  fields.Take(sizeof(uint16_t) + sizeof(uint32_t) + 2 * sizeof(uint64_t));
  const auto content = fields.rest();
  return {content.begin(), content.end()};
}

bool LooksLikeMcapFile(const std::string& path) {
  std::array<char, kMcapMagic.size()> begin{};
  std::ifstream file(path, std::ios::binary);
  return file.read(begin.data(), begin.size()) && std::string_view(begin.data(), begin.size()) == kMcapMagic;
}

}  // namespace plslam
