// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <list>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/files/dataset_error.h"

namespace plslam {

// Helpers that the readers of recordings share: bytes of the file, fields of its records, and its chunks. All throw
// DatasetError.

/// A file that is read in pieces, by several threads.
class RecordingFile {
 public:
  explicit RecordingFile(const std::string& path);
  ~RecordingFile();
  RecordingFile(const RecordingFile&) = delete;
  RecordingFile& operator=(const RecordingFile&) = delete;

  uint64_t size() const { return size_; }
  /// Fails if the piece, called `what`, is not within the file.
  std::vector<uint8_t> ReadAt(uint64_t offset, uint64_t n, const char* what) const;
  /// Announces a piece that will be read soon: the system may fetch many of them at once, while reading them one by one
  /// takes long.
  void WillRead(uint64_t offset, uint64_t n) const;

 private:
  int fd_ = -1;
  uint64_t size_ = 0;
};

/// Returns false also if the file cannot be read.
bool BeginsWith(const std::string& path, std::string_view magic);

inline constexpr uint64_t kMaxChunkBytes = 128 << 20;
/// Largest ratio of all that is decompressed to the file.
inline constexpr uint64_t kMostCompression = 1000;
/// Rejects a chunk, or a message outside of chunks, of more bytes than `kMaxChunkBytes`.
void CheckChunkSize(uint64_t n);

/// Fields of a record, one after the other without any alignment.
class RecordFields {
 public:
  explicit RecordFields(std::span<const uint8_t> bytes) : rest_(bytes) {}

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

/// Decompresses a chunk; `compression`: "" (none), "lz4" (frames), "zstd" or "bz2". `n` is its decompressed length
/// according to the file; one above `kMaxChunkBytes` is rejected.
std::vector<uint8_t> DecompressChunk(const std::string& compression, std::span<const uint8_t> bytes, uint64_t n);

/// Returns the bytes of lz4 that could be decompressed in the same time as `n` bytes of this compression.
uint64_t DecompressionCostOf(const std::string& compression, uint64_t n);

/// The chunks read last.
class RecentChunks {
 public:
  using Bytes = std::vector<uint8_t>;

  /// Returns the result of `find` on the chunk with this index, which `read` reads unless it is among the recent ones.
  Bytes Copy(uint32_t chunk, const std::function<Bytes()>& read,
             const std::function<std::span<const uint8_t>(const Bytes&)>& find);

 private:
  std::mutex mutex_;
  /// The most recently used one is first.
  std::list<std::pair<uint32_t, Bytes>> recent_;
};

}  // namespace plslam
