// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/loop_candidates.h"

#include <algorithm>
#include <functional>
#include <map>
#include <set>

namespace plslam::loop {
namespace {

// Least age of an old keyframe, in keyframes.
constexpr int64_t kBehind = 10;

// The keyframe, its predecessors, its neighbours by shared landmarks, and the neighbours of all of these.
std::set<KeyframeId> Surroundings(const Map& map, KeyframeId keyframe_id, const CandidateOptions& options) {
  std::set<KeyframeId> direct{keyframe_id};
  for (const Map::Neighbour& n : map.Neighbours(keyframe_id, options.min_shared)) direct.insert(n.keyframe_id);
  const MapKeyframe* before = map.FindKeyframe(keyframe_id);
  for (int i = 0; i < options.recent_keyframes && before != nullptr; ++i) {
    direct.insert(before->id);
    before = map.FindKeyframe(before->previous_id);
  }
  std::set<KeyframeId> all = direct;
  for (const KeyframeId id : direct) {
    for (const Map::Neighbour& n : map.Neighbours(id, options.min_shared)) all.insert(n.keyframe_id);
  }
  return all;
}

// Similarity to the previous keyframe, or to a neighbour: the score that a good match reaches in this image. 0 if
// neither is described.
double ReferenceScore(const Map& map, const PlaceRecogniser& places, KeyframeId keyframe_id,
                      const CandidateOptions& options) {
  const PlaceDescription& description = places.Of(keyframe_id);
  double best = 0.0;
  const KeyframeId previous_id = map.FindKeyframe(keyframe_id)->previous_id;
  if (places.Has(previous_id)) best = places.Score(description, places.Of(previous_id));
  for (const Map::Neighbour& n : map.Neighbours(keyframe_id, options.min_shared)) {
    if (!places.Has(n.keyframe_id)) continue;
    // Neighbours are sorted: this one shares most landmarks.
    return std::max(best, places.Score(description, places.Of(n.keyframe_id)));
  }
  return best;
}

// Joins matches that see the same landmarks; best group first.
std::vector<LoopCandidate> Group(const Map& map, const std::vector<PlaceMatch>& matches,
                                 const CandidateOptions& options) {
  std::map<KeyframeId, double> scores;
  for (const PlaceMatch& match : matches) scores[match.keyframe_id] = match.score;
  std::vector<LoopCandidate> groups;
  std::set<KeyframeId> taken;
  for (const PlaceMatch& match : matches) {
    if (!taken.insert(match.keyframe_id).second) continue;
    LoopCandidate group{match.keyframe_id, match.score, match.score};
    int joined = 0;
    for (const Map::Neighbour& n : map.Neighbours(match.keyframe_id, options.min_shared)) {
      if (joined++ == options.group_keyframes) break;
      const auto score = scores.find(n.keyframe_id);
      if (score == scores.end()) continue;
      group.group_score += score->second;
      taken.insert(n.keyframe_id);
    }
    groups.push_back(group);
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const LoopCandidate& a, const LoopCandidate& b) { return a.group_score > b.group_score; });
  return groups;
}

std::vector<LoopCandidate> Best(std::vector<LoopCandidate> groups, int max_count) {
  if (static_cast<int>(groups.size()) > max_count) groups.resize(static_cast<size_t>(max_count));
  return groups;
}

const LoopEdge* LastLoop(const Map& map, SessionId session) {
  for (auto loop = map.loops().rbegin(); loop != map.loops().rend(); ++loop) {
    const MapKeyframe* keyframe = map.FindKeyframe(loop->keyframe_id);
    if (keyframe != nullptr && keyframe->name.session == session) return &*loop;
  }
  return nullptr;
}

// Distance in metres; a rotation of one radian counts as two metres.
double Apart(const SE3& T) { return T.translation().norm() + 2.0 * T.Log().tail<3>().norm(); }

}  // namespace

std::vector<LoopCandidate> FindLoopCandidates(const Map& map, const PlaceRecogniser& places, KeyframeId keyframe_id,
                                              const CandidateOptions& options) {
  if (!places.Has(keyframe_id)) return {};
  const std::set<KeyframeId> excluded = Surroundings(map, keyframe_id, options);
  std::vector<PlaceMatch> matches = places.Query(
      places.Of(keyframe_id), [&](KeyframeId id) { return id > keyframe_id || excluded.contains(id); },
      options.max_queried);
  const double least = options.min_relative_score * ReferenceScore(map, places, keyframe_id, options);
  std::erase_if(matches, [least](const PlaceMatch& match) { return match.score < least; });
  return Best(Group(map, matches, options), options.max_candidates);
}

std::optional<LoopCandidate> FindSecondLook(const Map& map, KeyframeId keyframe_id, const CandidateOptions& options) {
  const MapKeyframe& keyframe = *map.FindKeyframe(keyframe_id);
  const LoopEdge* last = LastLoop(map, keyframe.name.session);
  if (last == nullptr || last->keyframe_id >= keyframe_id) return std::nullopt;
  const double last_m = Apart(last->T_old_kf);
  std::optional<LoopCandidate> nearest;
  double nearest_m = 0.5 * last_m;
  for (const Map::Neighbour& n : map.Neighbours(keyframe_id, options.min_shared)) {
    // Older than the new side of the loop, and not one of its predecessors.
    const MapKeyframe& old = *map.FindKeyframe(n.keyframe_id);
    if (old.name.session == keyframe.name.session && old.name.number + kBehind > keyframe.name.number) continue;
    if (n.keyframe_id.value + kBehind > last->keyframe_id.value) continue;
    const double apart_m = Apart(old.T_w_kf.Inverse() * keyframe.T_w_kf);
    if (apart_m > nearest_m) continue;
    nearest_m = apart_m;
    nearest = LoopCandidate{n.keyframe_id};
  }
  return last_m > options.near_m ? nearest : std::nullopt;
}

std::vector<LoopCandidate> FindPlaceCandidates(const Map& map, const PlaceRecogniser& places,
                                               const PlaceDescription& description, const CandidateOptions& options,
                                               int max_queried, int max_candidates) {
  const auto unknown = [&map](KeyframeId id) { return map.FindKeyframe(id) == nullptr; };
  return Best(Group(map, places.Query(description, unknown, max_queried), options), max_candidates);
}

}  // namespace plslam::loop
