// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/features/features.h"
#include "core/io/files/mapped_file.h"

namespace plslam {

/// Features that do not change any more: in memory, or in a file that is mapped into it. Copies share both.
class KeptFeatures : public FeaturesView {
 public:
  KeptFeatures() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): they are the same features.
  KeptFeatures(StereoFeatures features);

  /// All of them to one temporary file: they cost memory only as long as somebody looks at them. False, and nothing
  /// done, where it cannot be written.
  static bool MoveToFile(const std::vector<KeptFeatures*>& group);
  bool IsInFile() const { return file_ != nullptr; }
  /// Gives back the memory that looking at a file has cost.
  void LeaveMemory() const {
    if (IsInFile()) file_->LeaveMemory(begin_, points.size_bytes() + lines.size_bytes());
  }

 private:
  std::shared_ptr<const StereoFeatures> memory_;
  std::shared_ptr<const MappedFile> file_;
  size_t begin_ = 0;  ///< in the file
};

/// Features of the keyframes in the map, by their ids there.
using KeyframeFeatures = std::map<int64_t, KeptFeatures>;

/// Leaves the newest in memory, which is where trackers are, and moves the others to files; those that are there give
/// back the memory that looking at them has cost since the last call. Takes time in proportion to the map, so it is
/// done after every `kFilesEvery` keyframes; a file has the features of as many. False where a file could not be
/// written: its features, and those behind them, stay in memory.
bool LeaveOldInFiles(KeyframeFeatures& features);
inline constexpr int kFilesEvery = 16;
/// What to tell of the first time.
std::string CannotLeaveMemory();

}  // namespace plslam
