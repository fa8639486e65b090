// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/features/features.h"
#include "core/files/mapped_file.h"
#include "core/ids/ids.h"

namespace plslam {

/// Immutable features, in memory or in a memory-mapped file. Copies share them.
class KeptFeatures : public FeaturesView {
 public:
  KeptFeatures() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): the same features in another container.
  KeptFeatures(StereoFeatures features);

  /// Moves all of them to one temporary file, which occupies memory only while it is read. Returns false and does
  /// nothing if the file cannot be written.
  static bool MoveToFile(const std::vector<KeptFeatures*>& group);
  bool IsInFile() const { return file_ != nullptr; }
  /// Releases the memory that reading the file has occupied.
  void LeaveMemory() const {
    if (IsInFile()) file_->LeaveMemory(begin_, points.size_bytes() + lines.size_bytes());
  }

 private:
  std::shared_ptr<const StereoFeatures> memory_;
  std::shared_ptr<const MappedFile> file_;
  size_t begin_ = 0;  ///< offset in the file, in bytes
};

/// Features of the keyframes in the map, by keyframe id.
using KeyframeFeatures = std::map<KeyframeId, KeptFeatures>;

/// Moves the features of all but the newest keyframes, which are in use by trackers, to files, and releases memory that
/// reading older files has occupied. Takes time in proportion to the map: call it after every `kFilesEvery` keyframes,
/// the number in one file. Returns false if a file could not be written: its features, and later ones, stay in memory.
bool MoveOldToFiles(KeyframeFeatures& features);
inline constexpr int kFilesEvery = 16;
/// Returns the warning for the first failure.
std::string CannotLeaveMemory();

}  // namespace plslam
