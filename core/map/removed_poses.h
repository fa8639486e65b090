// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <vector>

#include "core/geometry/se3.h"
#include "core/ids/ids.h"
#include "core/map/id_map.h"
#include "core/map/keyframe.h"

namespace plslam {

/// A keyframe that was removed from the map, at its place in the present map.
struct RemovedKeyframe {
  KeyframeId id = -1;
  SessionId session;
  FrameId frame_id = -1;
  SE3 T_odom_kf;
  SE3 T_w_kf;
};

/// Poses of keyframes that were removed from a map. A removed keyframe keeps the pose that it had, and moves only with
/// corrections of the map (`Map::Move`), as its carrier moves. The carrier is a keyframe that was beside it; when the
/// carrier is removed, too, the carrier's own carrier takes both.
///
/// Local adjustments do not move removed keyframes: the small movements of one carrier after another would add up to a
/// random walk over the visits of a place.
///
/// With D_k(t), the product of all corrections of keyframe k until t (in the map frame), and c the carrier of k, which
/// was removed at s: D_k(t) = D_c(t) D_c(s)^-1 D_k(s), and its pose is D_k(t) D_k(s)^-1 T_w_kf(s).
class RemovedPoses {
 public:
  /// Version of the map that the following changes lead to; never less than the one before.
  void BeginVersion(int64_t version);
  int64_t version() const { return version_; }

  /// A correction has moved keyframes of the map; `T_new_old` is the displacement of each in the map frame.
  void Move(const std::map<KeyframeId, SE3>& T_new_old);
  /// The keyframe is being removed from the map. `carrier_id` is in the map, or -1: no correction moves the keyframe.
  void Add(const MapKeyframe& keyframe, KeyframeId carrier_id);
  /// The keyframe is in the map again.
  void Forget(KeyframeId id);
  /// Forgets removed keyframes. Those that they carry stay in place, and move with the next carrier.
  void Forget(const std::set<KeyframeId>& ids);
  /// Undoes what has happened since that version, when the map had `keyframes`: a mapping process that was killed
  /// continues from an older state, and repeats the rest. Corrections of more than `kKept` versions ago cannot be undone.
  void ReturnTo(int64_t version, const IdMap<KeyframeId, MapKeyframe>& keyframes);

  /// Ascending by id.
  std::vector<RemovedKeyframe> Keyframes() const;

 private:
  /// A thousand versions are more than lie between two states of a mapping process (`mapping.state_every`).
  static constexpr int64_t kKept = 1000;

  struct Removed {
    int64_t version = 0;
    SessionId session;
    FrameId frame_id = -1;
    SE3 T_odom_kf;
    SE3 T_w_kf;
    SE3 D_kf;
    KeyframeId carrier_id = -1;
    SE3 D_carrier;
  };
  struct Correction {
    int64_t version = 0;
    std::map<KeyframeId, SE3> D_before;
  };

  SE3 CorrectionOf(KeyframeId id) const;

  int64_t version_ = 0;
  std::map<KeyframeId, Removed> removed_;
  /// Product of the corrections of each keyframe of the map that was corrected.
  std::map<KeyframeId, SE3> D_;
  std::deque<Correction> corrections_;
};

}  // namespace plslam
