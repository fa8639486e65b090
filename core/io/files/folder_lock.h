// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam {

/// A folder that one process at a time writes its results into. The kernel lets go of it when the process ends,
/// however that happens, and no file is left. On file systems that cannot lock a folder (some network ones) nobody is
/// kept out.
class FolderLock {
 public:
  /// The folder exists. One that the process has that started this one is ours, too. Throws std::runtime_error where
  /// another has it, with one sentence that names the folder, that process and its command line.
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace plslam
