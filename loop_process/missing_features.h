// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/map.h"

namespace plslam::loop {

/// The keyframes of a complete map whose features have not arrived. Features are awaited during a limited time, and
/// requested before that. The caller passes the time.
class MissingFeatures {
 public:
  /// Time to wait after the last arrival.
  static constexpr double kPatience_ms = 3000.0;
  /// Without an arrival for this time, missing features are requested: their tracker has exited.
  static constexpr double kRequestAfter_ms = 1000.0;

  using HasFeatures = std::function<bool(const KeyframeName& keyframe)>;

  /// A complete map has arrived: all its keyframes without features are missing.
  void Begin(const Map& map, const HasFeatures& has_features, double now_ms);
  /// The map has changed: those that it has no longer are not missing.
  void Follow(const Map& map, const HasFeatures& has_features);
  void OnArrival(const KeyframeName& keyframe, double now_ms);

  /// Returns whether none is missing, or they have been given up.
  bool IsOver(double now_ms);
  /// Returns whether to request them now.
  bool TakeRequest(double now_ms);
  /// Their ids in the map.
  std::vector<KeyframeId> Ids(const Map& map) const;

 private:
  std::set<KeyframeName> keyframes_;
  double arrived_ms_ = 0.0;    ///< time of the complete map, or of the last arrival since
  double requested_ms_ = 0.0;  ///< time of the last request
};

}  // namespace plslam::loop
