// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace plslam {

/// Opens a new file without a name in the folder. On a file system without such files, one is created and its name
/// removed. Returns a descriptor to read and write, or -1 with errno.
int OpenNameless(const std::string& folder);

/// A file without a name in a folder, for what does not fit into memory: the system removes it when the process ends,
/// however that happens.
class NamelessFile {
 public:
  /// The file is created by the first `Write`.
  explicit NamelessFile(std::string folder) : folder_(std::move(folder)) {}
  ~NamelessFile();
  NamelessFile(NamelessFile&& other) noexcept;
  NamelessFile& operator=(NamelessFile&& other) noexcept;

  /// Returns false if the folder cannot be written or its disk is full; `failure` then is one sentence.
  bool Write(int64_t at, const void* bytes, size_t n);
  /// Reads what was written there. Throws std::runtime_error, naming the folder, if the disk fails.
  void Read(int64_t at, void* bytes, size_t n) const;

  const std::string& failure() const { return failure_; }

 private:
  bool Fail(int reason);

  std::string folder_;
  int descriptor_ = -1;
  std::string failure_;
};

}  // namespace plslam
