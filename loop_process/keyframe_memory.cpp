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

std::vector<NamedKeyframe> NamesIn(const Map& map, const LoopClosure& closure) {
  std::set<KeyframeId> ids;
  for (const LoopEdge& edge : closure.edges) ids.insert({edge.old_keyframe_id, edge.keyframe_id});
  for (const CorrectedPose& pose : closure.poses) ids.insert(pose.keyframe_id);
  std::vector<NamedKeyframe> names;
  names.reserve(ids.size());
  for (const KeyframeId id : ids) {
    const MapKeyframe* keyframe = map.FindKeyframe(id);
    if (keyframe != nullptr) names.push_back({id, keyframe->name});
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
  const KeyframeName& name = keyframe.name;
  if (!known_.insert(name).second) return false;
  waiting_[name] = keyframe.features;
  if (has_map_) DropUntaken(name.session);
  return true;
}

/// Drops the oldest first: a map that later receives the session starts with its newest keyframes.
void KeyframeMemory::DropUntaken(SessionId session) {
  if (taken_.contains(session)) return;
  auto oldest = waiting_.lower_bound({session, kLowest});
  const auto end = std::find_if_not(oldest, waiting_.end(),
                                    [session](const auto& waiting) { return waiting.first.session == session; });
  for (auto n = std::distance(oldest, end); n > kMostUntaken; --n) {
    known_.erase(oldest->first);
    oldest = waiting_.erase(oldest);
  }
}

void KeyframeMemory::Enter(KeyframeId id, const KeyframeName& name, KeptFeatures features) {
  taken_.insert(name.session);
  places_.Add(id, DescribePlace(places_, features, point_nodes_[id]));
  features_[id] = std::move(features);
  const std::pair entered(id, name);
  const auto place = std::lower_bound(names_.begin(), names_.end(), entered);
  const bool again = place != names_.end() && place->first == id;
  if (!again) names_.insert(place, entered);
}

void KeyframeMemory::Leave(KeyframeId id, const KeyframeName& name) {
  places_.Remove(id);
  waiting_[name] = std::move(features_.at(id));
  features_.erase(id);
  point_nodes_.erase(id);
}

void KeyframeMemory::DropIfEnded(SessionId session) {
  if (std::ranges::any_of(names_, [session](const auto& name) { return name.second.session == session; })) return;
  taken_.erase(session);
  std::erase_if(waiting_, [session](const auto& waiting) { return waiting.first.session == session; });
  std::erase_if(known_, [session](const KeyframeName& name) { return name.session == session; });
}

void KeyframeMemory::Follow(const Map& map, bool continues) {
  // Both ascend by id. A new map may give the same id to another keyframe.
  std::vector<std::pair<KeyframeId, KeyframeName>> gone;
  auto known = names_.begin();
  for (const auto& [id, keyframe] : map.keyframes()) {
    for (; known != names_.end() && known->first < id; ++known) gone.push_back(*known);
    if (known == names_.end() || known->first != id) continue;
    if (known->second != keyframe.name) gone.push_back(*known);
    ++known;
  }
  for (; known != names_.end(); ++known) gone.push_back(*known);
  if (!gone.empty()) {
    std::erase_if(names_, [&gone](const auto& name) { return std::binary_search(gone.begin(), gone.end(), name); });
  }
  for (const auto& [id, name] : gone) Leave(id, name);

  std::map<SessionId, int64_t> newest;  // of each session
  for (auto entry = map.keyframes().rbegin(); entry != map.keyframes().rend() && !waiting_.empty(); ++entry) {
    const KeyframeName& name = entry->second.name;
    newest.try_emplace(name.session, name.number);
    const auto found = waiting_.find(name);
    if (found == waiting_.end()) continue;
    Enter(entry->first, name, std::move(found->second));
    waiting_.erase(found);
  }
  std::erase_if(waiting_, [&](const auto& waiting) {
    const auto session = newest.find(waiting.first.session);
    const bool for_good = session != newest.end() && waiting.first.number < session->second;
    if (for_good) known_.erase(waiting.first);
    return for_good;
  });
  if (continues) {
    std::set<SessionId> left;
    for (const auto& [id, name] : gone) left.insert(name.session);
    for (const SessionId session : left) DropIfEnded(session);
  }
  has_map_ = has_map_ || !map.keyframes().empty();
  if (!has_map_) return;
  std::set<SessionId> sessions;
  for (const auto& [name, features] : waiting_) sessions.insert(name.session);
  for (const SessionId session : sessions) DropUntaken(session);
}

}  // namespace plslam::loop
