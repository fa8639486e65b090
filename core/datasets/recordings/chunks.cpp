// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/chunks.h"

#include <bzlib.h>
#include <fcntl.h>
#include <lz4frame.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <memory>

#include <fmt/format.h>

#include "core/errors/error_text.h"

namespace plslam {
namespace {

/// Left and right image, their truth, and the neighbours of all: each may be in another chunk.
constexpr size_t kChunksKept = 4;

[[noreturn]] void FailAsDamaged(const char* compression, const char* why) {
  throw DatasetError(fmt::format("a chunk is damaged: {} reports '{}'", compression, why));
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
    if (in_bytes == 0 && out_bytes == 0) FailAsDamaged("lz4", "more bytes than the size of the chunk");
  }
  return out_done;
}

uint64_t Unbz2(std::span<const uint8_t> in, std::vector<uint8_t>& out) {
  auto n = static_cast<unsigned>(out.size());
  // The library takes no constant input, but does not change it.
  auto* const from = const_cast<char*>(reinterpret_cast<const char*>(in.data()));  // NOLINT
  const int result = BZ2_bzBuffToBuffDecompress(reinterpret_cast<char*>(out.data()), &n, from,
                                                static_cast<unsigned>(in.size()), 0, 0);
  if (result == BZ_OUTBUFF_FULL) FailAsDamaged("bz2", "more bytes than the size of the chunk");
  if (result != BZ_OK) FailAsDamaged("bz2", fmt::format("error {}", result).c_str());
  return n;
}

/// A compression of chunks, and how many times as long as lz4 it takes.
struct Codec {
  std::string_view name;
  uint64_t (*decompress)(std::span<const uint8_t> in, std::vector<uint8_t>& out);
  uint64_t slowness;
};
constexpr auto kCodecs = std::to_array<Codec>({{"lz4", Unlz4, 1}, {"zstd", Unzstd, 2}, {"bz2", Unbz2, 50}});

}  // namespace

RecordingFile::RecordingFile(const std::string& path) : fd_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  struct stat status {};
  if (fd_ < 0 || fstat(fd_, &status) != 0) {
    const int reason = errno;
    if (fd_ >= 0) close(fd_);
    throw DatasetError(fmt::format("cannot be read: {}", ReasonOf(reason)));
  }
  size_ = static_cast<uint64_t>(status.st_size);
}

RecordingFile::~RecordingFile() { close(fd_); }

std::vector<uint8_t> RecordingFile::ReadAt(uint64_t offset, uint64_t n, const char* what) const {
  if (offset > size_ || n > size_ - offset) {
    throw DatasetError(fmt::format("{} would begin after the end of the file: it is damaged or truncated", what));
  }
  std::vector<uint8_t> bytes =
      WithMemoryFor(fmt::format("{} of {} bytes", what, n), [&] { return std::vector<uint8_t>(n); });
  for (uint64_t done = 0; done < n;) {
    const ssize_t got = pread(fd_, bytes.data() + done, n - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw DatasetError(fmt::format("{} cannot be read: {}", what, ReasonOf(got < 0 ? errno : EIO)));
    done += static_cast<uint64_t>(got);
  }
  return bytes;
}

void RecordingFile::WillRead(uint64_t offset, uint64_t n) const {
  posix_fadvise(fd_, static_cast<off_t>(offset), static_cast<off_t>(n), POSIX_FADV_WILLNEED);
}

bool BeginsWith(const std::string& path, std::string_view magic) {
  std::string begin(magic.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  return file.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == magic;
}

void CheckChunkSize(uint64_t n) {
  if (n <= kMaxChunkBytes) return;
  throw DatasetError(
      fmt::format("a chunk of {} bytes, more than {}: `mcap compress` or `rosbag compress` writes smaller ones", n,
                  kMaxChunkBytes));
}

std::vector<uint8_t> DecompressChunk(const std::string& compression, std::span<const uint8_t> bytes, uint64_t n) {
  CheckChunkSize(n);
  if (compression.empty()) {
    if (n != bytes.size()) FailAsDamaged("the file", "another length");
    return {bytes.begin(), bytes.end()};
  }
  const auto* const codec =
      std::find_if(kCodecs.begin(), kCodecs.end(), [&](const Codec& c) { return c.name == compression; });
  if (codec == kCodecs.end()) {
    throw DatasetError(
        fmt::format("its chunks are compressed with '{}', not with lz4, zstd or bz2", Shown(compression)));
  }
  constexpr uint64_t kMostOfLz4 = 255;  // bytes that one byte of it can give; the others have no such bound
  if (compression == "lz4" && n > kMostOfLz4 * bytes.size()) FailAsDamaged("lz4", "another length");
  auto out = WithMemoryFor(fmt::format("a chunk of {} bytes", n), [&] { return std::vector<uint8_t>(n); });
  const uint64_t got = codec->decompress(bytes, out);
  if (got != n) FailAsDamaged(compression.c_str(), "another length");
  return out;
}

uint64_t DecompressionCostOf(const std::string& compression, uint64_t n) {
  const auto* const codec =
      std::find_if(kCodecs.begin(), kCodecs.end(), [&](const Codec& c) { return c.name == compression; });
  return codec == kCodecs.end() ? 0 : codec->slowness * std::min(n, kMaxChunkBytes);
}

RecentChunks::Bytes RecentChunks::Copy(uint32_t chunk, const std::function<Bytes()>& read,
                                       const std::function<std::span<const uint8_t>(const Bytes&)>& find) {
  const std::scoped_lock lock(mutex_);
  const auto known =
      std::find_if(recent_.begin(), recent_.end(), [&](const auto& recent) { return recent.first == chunk; });
  if (known != recent_.end()) {
    recent_.splice(recent_.begin(), recent_, known);
  } else {
    Bytes bytes = read();
    if (recent_.size() == kChunksKept) recent_.pop_back();
    recent_.emplace_front(chunk, std::move(bytes));
  }
  const auto found = find(recent_.front().second);
  return {found.begin(), found.end()};
}

}  // namespace plslam
