// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/map/keyframe.h"
#include "core/map/landmark_types.h"
#include "core/map/map.h"
#include "core/places/place_recogniser.h"

namespace plslam::loop {

/// Names of those keyframes that edges and poses of the closure speak of and the map has, ascending by id.
std::vector<KeyframeName> NamesIn(const Map& map, const LoopClosure& closure);

/// What a place looks like, and the nodes of its points in the vocabulary.
PlaceDescription DescribePlace(const PlaceRecogniser& places, const FeaturesView& features,
                               FeatureNodes& point_nodes);

/// Features of the keyframes and the index of places, by the ids of the map. Features and map come from two senders,
/// so either may know of a keyframe first; and a map may be replaced by one that starts anew.
class KeyframeMemory {
 public:
  /// Of a session that no map has taken anything of so far (of another map, say) only so many wait, the newest: as
  /// many as a map that is built anew may be behind.
  static constexpr int64_t kMostUntaken = 500;

  explicit KeyframeMemory(PlaceRecogniser places) : places_(std::move(places)) {}

  /// Features of a keyframe, as its session numbers it. False where they are here already.
  bool Add(const Keyframe& keyframe);

  /// Whether the features of a keyframe are here. Of one that has gone for good they are not.
  bool Knows(int64_t session, int64_t keyframe_id) const { return known_.contains({session, keyframe_id}); }

  /// Sessions that the next map to follow has nothing of count as untaken (`kMostUntaken`).
  void ForgetSessions() { taken_.clear(); }

  /// Keyframes that the map has come in, those it has no more go. Features of others wait as long as the map may
  /// still take them, that is until a later keyframe of their session is in it; see also `kMostUntaken`. Before there
  /// is a map all wait.
  void Follow(const Map& map);

  /// Features of keyframes that are not among the newest leave the memory (`plslam::LeaveOldInFiles`).
  bool LeaveOldInFiles() { return plslam::LeaveOldInFiles(features_); }

  /// Those of the map, as of the last `Follow`, that came with features.
  const KeyframeFeatures& features() const { return features_; }
  /// Nodes of their points in the vocabulary, by the same ids.
  const std::map<int64_t, FeatureNodes>& point_nodes() const { return point_nodes_; }
  const PlaceRecogniser& places() const { return places_; }

 private:
  /// Session, and number there.
  using Name = std::pair<int64_t, int64_t>;

  void Enter(int64_t id, const Name& name, KeptFeatures features);
  void Leave(int64_t id, const Name& name);
  void DropUntaken(int64_t session);

  PlaceRecogniser places_;
  std::set<Name> known_;  // of all whose features are here, waiting or not
  std::map<Name, KeptFeatures> waiting_;
  std::set<int64_t> taken_;  // sessions of which a map has ever had a keyframe
  bool has_map_ = false;
  KeyframeFeatures features_;
  std::map<int64_t, FeatureNodes> point_nodes_;
  // Of those that have entered, ascending by id: every keyframe reads all of them, so they lie together.
  std::vector<std::pair<int64_t, Name>> names_;
};

}  // namespace plslam::loop
