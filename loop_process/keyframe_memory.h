// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/keyframe.h"
#include "core/map/landmark_types.h"
#include "core/map/map.h"
#include "core/places/place_recogniser.h"

namespace plslam::loop {

/// Returns the names of the keyframes in the edges and poses of the closure that the map has, ascending by id.
std::vector<NamedKeyframe> NamesIn(const Map& map, const LoopClosure& closure);

/// Returns the layout and the words of an image; `point_nodes` receives the vocabulary node of each point.
PlaceDescription DescribePlace(const PlaceRecogniser& places, const FeaturesView& features,
                               FeatureNodes& point_nodes);

/// Features of the keyframes and the index of places, by the ids of the map. Two processes publish features and map,
/// so either may arrive first; and a new map may replace the current one.
class KeyframeMemory {
 public:
  /// Waiting keyframes kept of a session that is not in any map yet (it may belong to another map): the newest ones, as
  /// many as a map that is being rebuilt may still insert.
  static constexpr int64_t kMostUntaken = 500;

  explicit KeyframeMemory(PlaceRecogniser places) : places_(std::move(places)) {}

  /// Adds the features of a keyframe, numbered within its session. Returns false if they are already stored.
  bool Add(const Keyframe& keyframe);

  /// Whether the features of a keyframe are stored. False for a keyframe that was dropped.
  bool Contains(const KeyframeName& keyframe) const { return known_.contains(keyframe); }

  /// Applies `kMostUntaken` again to sessions that are not in the next map passed to `Follow`.
  void ForgetSessions() { taken_.clear(); }

  /// Adds keyframes that entered the map, and removes those that left it. Features of other keyframes wait while the
  /// map may still insert them, which is until a later keyframe of their session is in it; see also `kMostUntaken`.
  /// All of them wait until there is a map.
  ///
  /// `continues`: it is the same map as before, so a session whose last keyframe left it has ended, and its features are
  /// dropped. (A map that is being rebuilt inserts keyframes again.)
  void Follow(const Map& map, bool continues = false);

  /// Moves features of keyframes that are not among the newest to a file (`plslam::MoveOldToFiles`).
  bool MoveOldToFiles() { return plslam::MoveOldToFiles(features_); }

  /// Features of the map's keyframes, as of the last `Follow`, by keyframe id.
  const KeyframeFeatures& features() const { return features_; }
  /// Vocabulary nodes of their points, by the same ids.
  const std::map<KeyframeId, FeatureNodes>& point_nodes() const { return point_nodes_; }
  const PlaceRecogniser& places() const { return places_; }

 private:
  void Enter(KeyframeId id, const KeyframeName& name, KeptFeatures features);
  void Leave(KeyframeId id, const KeyframeName& name);
  void DropUntaken(SessionId session);
  void DropIfEnded(SessionId session);

  PlaceRecogniser places_;
  std::set<KeyframeName> known_;  // keyframes whose features are stored, waiting or not
  std::map<KeyframeName, KeptFeatures> waiting_;
  std::set<SessionId> taken_;  // sessions that have had a keyframe in a map
  bool has_map_ = false;
  KeyframeFeatures features_;
  std::map<KeyframeId, FeatureNodes> point_nodes_;
  // Keyframes that have entered, ascending by id; contiguous, because `Follow` reads all of them.
  std::vector<std::pair<KeyframeId, KeyframeName>> names_;
};

}  // namespace plslam::loop
