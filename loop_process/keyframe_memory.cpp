// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/keyframe_memory.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "core/features/matching/hamming.h"

namespace plslam::loop {

std::vector<KeyframeName> NamesIn(const Map& map, const LoopClosure& closure) {
  std::set<int64_t> ids;
  for (const LoopEdge& edge : closure.edges) ids.insert({edge.old_keyframe_id, edge.keyframe_id});
  for (const CorrectedPose& pose : closure.poses) ids.insert(pose.keyframe_id);
  std::vector<KeyframeName> names;
  names.reserve(ids.size());
  for (const int64_t id : ids) {
    const MapKeyframe* keyframe = map.FindKeyframe(id);
    if (keyframe != nullptr) names.push_back({id, keyframe->session, keyframe->session_keyframe_id});
  }
  return names;
}

namespace {

constexpr int64_t kLowest = std::numeric_limits<int64_t>::min();

}  // namespace

PlaceDescription DescribePlace(const PlaceRecogniser& places, const FeaturesView& features,
                               FeatureNodes& point_nodes) {
  PlaceDescription description = DescribeLayout(features);
  description.points = places.point_vocabulary().Transform(DescriptorsOf(features.points), point_nodes);
  description.lines = places.line_vocabulary().Transform(DescriptorsOf(features.lines));
  return description;
}

bool KeyframeMemory::Add(const Keyframe& keyframe) {
  const Name name{keyframe.session, keyframe.keyframe_id};
  if (!known_.insert(name).second) return false;
  waiting_[name] = keyframe.features;
  if (has_map_) DropUntaken(name.first);
  return true;
}

/// Drops the oldest first: a map that later receives the session starts with its newest keyframes.
void KeyframeMemory::DropUntaken(int64_t session) {
  if (taken_.contains(session)) return;
  auto oldest = waiting_.lower_bound({session, kLowest});
  const auto end = std::find_if_not(oldest, waiting_.end(),
                                    [session](const auto& waiting) { return waiting.first.first == session; });
  for (auto n = std::distance(oldest, end); n > kMostUntaken; --n) {
    known_.erase(oldest->first);
    oldest = waiting_.erase(oldest);
  }
}

void KeyframeMemory::Enter(int64_t id, const Name& name, KeptFeatures features) {
  taken_.insert(name.first);
  places_.Add(id, DescribePlace(places_, features, point_nodes_[id]));
  features_[id] = std::move(features);
  const std::pair entered(id, name);
  const auto place = std::lower_bound(names_.begin(), names_.end(), entered);
  const bool again = place != names_.end() && place->first == id;
  if (!again) names_.insert(place, entered);
}

void KeyframeMemory::Leave(int64_t id, const Name& name) {
  places_.Remove(id);
  waiting_[name] = std::move(features_.at(id));
  features_.erase(id);
  point_nodes_.erase(id);
}

void KeyframeMemory::Follow(const Map& map) {
  // Both ascend by id. A new map may give the same id to another keyframe.
  std::vector<std::pair<int64_t, Name>> gone;
  auto known = names_.begin();
  for (const auto& [id, keyframe] : map.keyframes()) {
    for (; known != names_.end() && known->first < id; ++known) gone.push_back(*known);
    if (known == names_.end() || known->first != id) continue;
    if (known->second != Name{keyframe.session, keyframe.session_keyframe_id}) gone.push_back(*known);
    ++known;
  }
  for (; known != names_.end(); ++known) gone.push_back(*known);
  if (!gone.empty()) {
    std::erase_if(names_, [&gone](const auto& name) { return std::binary_search(gone.begin(), gone.end(), name); });
  }
  for (const auto& [id, name] : gone) Leave(id, name);

  std::map<int64_t, int64_t> newest;  // of each session
  for (auto entry = map.keyframes().rbegin(); entry != map.keyframes().rend() && !waiting_.empty(); ++entry) {
    const Name name{entry->second.session, entry->second.session_keyframe_id};
    newest.try_emplace(name.first, name.second);
    const auto found = waiting_.find(name);
    if (found == waiting_.end()) continue;
    Enter(entry->first, name, std::move(found->second));
    waiting_.erase(found);
  }
  std::erase_if(waiting_, [&](const auto& waiting) {
    const auto session = newest.find(waiting.first.first);
    const bool for_good = session != newest.end() && waiting.first.second < session->second;
    if (for_good) known_.erase(waiting.first);
    return for_good;
  });
  has_map_ = has_map_ || !map.keyframes().empty();
  if (!has_map_) return;
  std::set<int64_t> sessions;
  for (const auto& [name, features] : waiting_) sessions.insert(name.first);
  for (const int64_t session : sessions) DropUntaken(session);
}

}  // namespace plslam::loop
