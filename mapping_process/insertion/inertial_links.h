// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>

#include "core/ids/ids.h"
#include "core/inertial/inertial_interval.h"
#include "core/map/map.h"
#include "core/optim/bundle/map_bundle.h"

namespace plslam::mapping {

/// Motions between successive keyframes of the map as inertial sensors sensed them, for its newest keyframes: earlier
/// ones are adjusted no more.
class InertialLinks {
 public:
  /// Adds what was sensed between a new keyframe and the previous one of its session, which `map` has. Ignores an
  /// interval that does not begin there: it is empty, or a keyframe in between did not arrive.
  void Add(const MapKeyframe& keyframe, const InertialInterval& interval, const Map& map);
  /// The keyframe is not in the map any more: its two links become one.
  void Remove(KeyframeId keyframe_id);

  /// Adds the motions between keyframes of the bundle to its problem, and gravity as the map measured it. Does nothing
  /// while no vertical is known.
  void AddTo(MapBundle& bundle, const Map& map);

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.links_, self.biases_);
  }

 private:
  struct Link {
    KeyframeId previous_id;
    SessionId session;
    /// The mean of its `bias` is that of `sensed`.
    InertialInterval interval;
    /// The motion, once it is integrated.
    std::optional<Preintegration> sensed;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.previous_id, self.session, self.interval);
    }
  };

  /// Integrates the motion, again if the bias has left the range in which it is linear. Returns nullptr if samples are
  /// missing.
  static const Preintegration* Sensed(const ImuBias& bias, Link& link);

  std::map<KeyframeId, Link> links_;             ///< by the later keyframe
  std::map<SessionId, ImuBiasEstimate> biases_;  ///< the newest of each session's sensor
};

}  // namespace plslam::mapping
