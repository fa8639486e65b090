// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>

#include "core/io/files/folder_lock.h"

namespace plslam {

/// The folder of a run's outputs, which for the life of this object no other run writes into. Unless it is kept, what
/// was made here goes again at the end: folders, and logs of processes that came to nothing. What earlier runs have
/// left stays.
class OutputFolder {
 public:
  /// Makes `folder` and its `logs`. Throws std::runtime_error, and leaves everything as it was, where they cannot be
  /// made, or another run has the folder.
  explicit OutputFolder(const std::filesystem::path& folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  void Keep() { kept_ = true; }
  bool is_kept() const { return kept_; }
  /// Of an earlier run.
  bool has_results() const;

 private:
  void Remove() const;

  const std::filesystem::path folder_;
  std::filesystem::path first_made_;  ///< the outermost folder that there was not; empty: there were all
  std::optional<FolderLock> lock_;
  bool kept_ = false;
};

}  // namespace plslam
