// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace plslam {

// Files and messages that ROS 2 recorded with `--compression-format zstd`. All throw DatasetError without the name of
// the file.

/// The bytes begin as frames of zstd do. No message of ROS 2 does.
bool IsZstd(std::span<const uint8_t> bytes);

/// Returns the content of a frame; one of more bytes than `kMaxChunkBytes` is rejected.
std::vector<uint8_t> UnzstdMessage(std::span<const uint8_t> frame);

/// Decompresses a file into a temporary one that the destructor removes. Its content may have 1000 times its bytes.
class UnzstdFile {
 public:
  explicit UnzstdFile(const std::string& path);
  ~UnzstdFile();
  UnzstdFile(const UnzstdFile&) = delete;
  UnzstdFile& operator=(const UnzstdFile&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace plslam
