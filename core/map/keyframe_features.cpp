// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/keyframe_features.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace plslam {
namespace {

constexpr size_t kNewestInMemory = 64;

// Lines follow the points in the file.
static_assert(alignof(StereoLine) <= alignof(StereoPoint) && sizeof(StereoPoint) % alignof(StereoLine) == 0);
static_assert(std::is_trivially_destructible_v<StereoPoint> && std::is_trivially_destructible_v<StereoLine>);

}  // namespace

KeptFeatures::KeptFeatures(StereoFeatures features)
    : memory_(std::make_shared<const StereoFeatures>(std::move(features))) {
  static_cast<FeaturesView&>(*this) = *memory_;
}

bool KeptFeatures::MoveToFile(const std::vector<KeptFeatures*>& group) {
  static constexpr std::array<std::byte, MappedFile::kPage> kNothing{};
  std::vector<std::span<const std::byte>> parts;
  std::vector<size_t> begins;
  size_t size = 0;
  for (const KeptFeatures* features : group) {
    begins.push_back(size);
    parts.push_back(std::as_bytes(features->points));
    parts.push_back(std::as_bytes(features->lines));
    const size_t beyond_page = (parts.back().size() + parts[parts.size() - 2].size()) % MappedFile::kPage;
    parts.push_back(std::span(kNothing).first(beyond_page == 0 ? 0 : MappedFile::kPage - beyond_page));
    for (size_t i = parts.size() - 3; i < parts.size(); ++i) size += parts[i].size();
  }
  const auto file = MappedFile::Temporary(parts);
  if (file == nullptr) return false;
  for (size_t i = 0; i < group.size(); ++i) {
    KeptFeatures& features = *group[i];
    features.begin_ = begins[i];
    const std::byte* data = file->data() + begins[i];
    features.points = {reinterpret_cast<const StereoPoint*>(data), features.points.size()};
    features.lines = {reinterpret_cast<const StereoLine*>(data + features.points.size_bytes()),
                      features.lines.size()};
    features.file_ = file;
    features.memory_.reset();
  }
  return true;
}

bool MoveOldToFiles(KeyframeFeatures& features) {
  size_t n_older = features.size() - std::min(features.size(), kNewestInMemory);
  std::vector<KeptFeatures*> group;
  for (auto entry = features.begin(); n_older > 0; ++entry, --n_older) {
    entry->second.LeaveMemory();
    if (!entry->second.IsInFile()) group.push_back(&entry->second);
    const bool is_full = group.size() == kFilesEvery || (n_older == 1 && !group.empty());
    if (!is_full) continue;
    if (!KeptFeatures::MoveToFile(group)) return false;
    group.clear();
  }
  return true;
}

std::string CannotLeaveMemory() {
  return "features of old keyframes are kept in memory: no file can be written in " + TemporaryRoot() +
         "; set TMPDIR to another folder";
}

}  // namespace plslam
