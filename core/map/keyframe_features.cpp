// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/keyframe_features.h"

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace plslam {
namespace {

constexpr size_t kNewestInMemory = 64;

// Lines lie behind points.
static_assert(alignof(StereoLine) <= alignof(StereoPoint) && sizeof(StereoPoint) % alignof(StereoLine) == 0);
static_assert(std::is_trivially_destructible_v<StereoPoint> && std::is_trivially_destructible_v<StereoLine>);

}  // namespace

KeptFeatures::KeptFeatures(StereoFeatures features)
    : memory_(std::make_shared<const StereoFeatures>(std::move(features))) {
  static_cast<FeaturesView&>(*this) = *memory_;
}

bool KeptFeatures::MoveToFile() {
  if (IsInFile()) return true;
  auto file = MappedFile::Temporary({std::as_bytes(points), std::as_bytes(lines)});
  if (file == nullptr) return false;
  points = {reinterpret_cast<const StereoPoint*>(file->data()), points.size()};
  lines = {reinterpret_cast<const StereoLine*>(file->data() + points.size_bytes()), lines.size()};
  file_ = std::move(file);
  memory_.reset();
  return true;
}

bool LeaveOldInFiles(KeyframeFeatures& features) {
  size_t n_older = features.size() - std::min(features.size(), kNewestInMemory);
  bool all_written = true;
  for (auto entry = features.begin(); n_older > 0; ++entry, --n_older) {
    entry->second.LeaveMemory();
    all_written = entry->second.MoveToFile() && all_written;
  }
  return all_written;
}

std::string CannotLeaveMemory() {
  return "features of old keyframes stay in memory: no file can be written in " + TemporaryRoot() +
         "; TMPDIR names another folder";
}

}  // namespace plslam
