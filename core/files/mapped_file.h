// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace plslam {

/// Returns the folder of files that end with the process: TMPDIR if it is set, else /var/tmp, which is on a disk even
/// if /tmp is in memory.
std::string TemporaryRoot();

/// A read-only memory-mapped file, which must not change meanwhile.
class MappedFile {
 public:
  /// Throws std::runtime_error, in a sentence without its subject, if it cannot be read.
  static std::shared_ptr<const MappedFile> Open(const std::string& path);
  /// Returns a file without a name in `TemporaryRoot`, which is removed with this object; it contains the parts one
  /// after the other. Returns nullptr if they cannot be written.
  static std::shared_ptr<const MappedFile> Temporary(const std::vector<std::span<const std::byte>>& parts);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  /// At an address for values of any type.
  const std::byte* data() const { return data_; }
  std::span<const uint8_t> bytes() const { return {reinterpret_cast<const uint8_t*>(data_), size_}; }
  /// Releases the memory of `size` bytes from `begin` on, which is read from the file again when needed. `begin` is a
  /// multiple of `kPage`.
  void LeaveMemory(size_t begin, size_t size) const;
  static constexpr size_t kPage = 4096;

 private:
  static std::shared_ptr<const MappedFile> Map(int file, size_t size);
  MappedFile(const std::byte* data, size_t size) : data_(data), size_(size) {}

  const std::byte* data_;
  size_t size_;
};

}  // namespace plslam
