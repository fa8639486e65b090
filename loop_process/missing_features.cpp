// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/missing_features.h"

#include <algorithm>
#include <utility>

namespace plslam::loop {

void MissingFeatures::Begin(const Map& map, const HasFeatures& has_features, double now_ms) {
  keyframes_.clear();
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (!has_features(keyframe.name)) keyframes_.insert(keyframe.name);
  }
  arrived_ms_ = now_ms;
}

void MissingFeatures::Follow(const Map& map, const HasFeatures& has_features) {
  if (keyframes_.empty()) return;
  const auto before = std::exchange(keyframes_, {});
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (before.contains(keyframe.name) && !has_features(keyframe.name)) keyframes_.insert(keyframe.name);
  }
}

void MissingFeatures::OnArrival(const KeyframeName& keyframe, double now_ms) {
  if (keyframes_.erase(keyframe) > 0) arrived_ms_ = now_ms;
}

bool MissingFeatures::IsOver(double now_ms) {
  if (!keyframes_.empty() && now_ms - arrived_ms_ >= kPatience_ms) keyframes_.clear();
  return keyframes_.empty();
}

bool MissingFeatures::TakeRequest(double now_ms) {
  if (keyframes_.empty() || now_ms - std::max(arrived_ms_, requested_ms_) < kRequestAfter_ms) return false;
  requested_ms_ = now_ms;
  return true;
}

std::vector<KeyframeId> MissingFeatures::Ids(const Map& map) const {
  std::vector<KeyframeId> ids;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframes_.contains(keyframe.name)) ids.push_back(id);
  }
  return ids;
}

}  // namespace plslam::loop
