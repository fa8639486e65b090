// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace plslam {

/// Where files go that end with the process: TMPDIR where that is set, else /var/tmp, which lies on a disk also where
/// /tmp lies in memory.
std::string TemporaryRoot();

/// A file that is mapped into memory to be read, and that nobody changes meanwhile.
class MappedFile {
 public:
  /// Throws std::runtime_error, in a sentence without its subject, where it cannot be read.
  static std::shared_ptr<const MappedFile> Open(const std::string& path);
  /// A file without a name in `TemporaryRoot`, which goes with this; in it the parts one after the other. nullptr where
  /// they cannot be written.
  static std::shared_ptr<const MappedFile> Temporary(const std::vector<std::span<const std::byte>>& parts);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  /// At an address for values of any type.
  const std::byte* data() const { return data_; }
  std::span<const uint8_t> bytes() const { return {reinterpret_cast<const uint8_t*>(data_), size_}; }
  /// Gives back the memory that reading `size` bytes from `begin` on has cost; what is read again comes from the file.
  /// `begin` is a multiple of `kPage`.
  void LeaveMemory(size_t begin, size_t size) const;
  static constexpr size_t kPage = 4096;

 private:
  static std::shared_ptr<const MappedFile> Map(int file, size_t size);
  MappedFile(const std::byte* data, size_t size) : data_(data), size_(size) {}

  const std::byte* data_;
  size_t size_;
};

}  // namespace plslam
