// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "core/ids/ids.h"
#include "core/io/trajectories/trajectory.h"
#include "core/map/map.h"
#include "core/map/map_parts.h"
#include "core/run/recorder.h"

namespace plslam {

/// Frames whose published pose has a known place in the map. The first frames of a session are published before the
/// tracker knows that; they count if their T_w_odom turned out to be right. All frames count if none is anchored.
class LiveAnchors {
 public:
  explicit LiveAnchors(const Recorder& recorder);
  bool Has(const FrameRecord& frame) const;

 private:
  std::map<SessionId, SE3> first_;  ///< T_w_odom of the first anchored frame, by session
};

/// T_w_odom by frame.
using FrameCorrections = std::map<FrameId, SE3>;

/// The map's corrections of odometry at its keyframes, those included that it remembers although they were removed, by
/// session: T_w_kf * T_odom_kf^-1.
std::map<SessionId, FrameCorrections> CorrectionsBySession(const Map& map);

/// Poses of frames in the final map: odometry, corrected as the map corrected the neighbouring keyframes.
class FinalPoses {
 public:
  FinalPoses(const Map& map, const Recorder& recorder);

  /// Returns T_w_c of a frame. Between two keyframes of the session the corrections of both are applied and the results
  /// blended by the number of frames (translation on the straight line, rotation on the great arc); before the first
  /// and after the last keyframe, and on either side of lost frames, where the motion is unknown, the nearest
  /// correction is used. A session without keyframes in the map keeps its published poses.
  SE3 operator()(FrameId frame_id, const FrameRecord& frame) const;

 private:
  std::map<SessionId, FrameCorrections> corrections_;
  std::set<FrameId> lost_frames_;
};

/// The unconnected parts of a map (`PartsOf`), and the sessions of a run in them. The map must outlive it.
class RunParts {
 public:
  RunParts(const Map& map, const Recorder& recorder);

  /// Returns the number of parts, at least 1; the main one is 0.
  size_t size() const { return parts_.empty() ? 1 : parts_.size(); }
  /// Returns the part of a session: the main one if the session has no keyframes in the map.
  size_t Of(SessionId session) const;
  const Map& MapOf(size_t part) const { return parts_.empty() ? *map_ : parts_[part]; }

 private:
  const Map* map_;
  std::vector<Map> parts_;  ///< empty if all is connected
  std::map<SessionId, size_t> part_of_session_;
};

/// T_w_c of the map's keyframes of recorded sessions, in the order of time.
Trajectory KeyframeTrajectory(const Map& map, const Recorder& recorder);

}  // namespace plslam
