// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam {

/// A folder into which one process at a time writes its results. The kernel releases it when the process ends, however
/// that happens, and no lock file is left. On file systems that cannot lock a folder (some network ones) other
/// processes are not kept out.
class FolderLock {
 public:
  /// The folder must exist. A lock of the parent process counts as ours. Throws std::runtime_error if another process
  /// has it, with one sentence that names the folder, that process and its command line.
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace plslam
