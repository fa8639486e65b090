// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "core/files/folder_lock.h"

namespace plslam::viewer {

/// The output folder of a viewer, locked. Results of an earlier run stay until there can be others.
class ResultFolder {
 public:
  /// Treatment of these results: the viewer does not start; removes them when its own run begins; or leaves that to the
  /// launcher.
  enum class Earlier { kRefuse, kReplace, kKeep };

  /// Makes the folder. Throws std::runtime_error if it cannot be written, another process has it, or it has results
  /// (`kRefuse`).
  ResultFolder(const std::string& path, Earlier earlier);

  /// The first frame of a run has a pose.
  void BeginRun() { replaces_ = earlier_ == Earlier::kReplace; }
  /// A run that has begun can write its results: removes the earlier ones, once.
  void RemoveEarlier();
  /// A second stream replaces the results of the first.
  void ReplaceOwn();

  bool replaces_earlier() const { return earlier_ == Earlier::kReplace; }

 private:
  std::string path_;
  Earlier earlier_;
  std::optional<FolderLock> lock_;
  bool replaces_ = false;  ///< the earlier results are to be removed
};

}  // namespace plslam::viewer
