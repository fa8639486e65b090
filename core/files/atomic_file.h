// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdio>
#include <initializer_list>
#include <string>
#include <string_view>

namespace plslam {

/// A file that is written beside PATH (`PATH.part`) and replaces it when it is complete, so that a reader sees the old
/// file or the new one. A device or a pipe (/dev/stdout) is written directly, and never replaced. Throws
/// std::runtime_error, naming the file and the reason of the system.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  /// Removes the file unless `PutInPlace` was called.
  ~AtomicFile();

  void Append(std::string_view bytes);
  /// Replaces the first bytes.
  void OverwriteBeginning(std::string_view bytes);
  /// Writes what was appended to the disk itself: from then on it survives a power cut, once it is in place.
  void Sync();
  void PutInPlace();

 private:
  void RemovePart();
  [[noreturn]] void Fail(const char* what, const std::string& besides = "");

  std::string path_;
  std::string part_path_;
  std::FILE* file_;
  uint64_t size_ = 0;
};

/// Replaces the file by `content`, as `AtomicFile` does.
void WriteFileAtomically(const std::string& path, std::string_view content);
/// Writes the parts one after the other.
void WriteFileAtomically(const std::string& path, std::initializer_list<std::string_view> parts);

/// Creates the folder and its missing parents. An empty name is the current folder: nothing is created. Throws
/// std::runtime_error with one sentence.
void MakeFolder(const std::string& folder);

}  // namespace plslam
