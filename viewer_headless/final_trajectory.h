// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>

#include "core/io/trajectories/trajectory.h"
#include "core/map/map.h"
#include "viewer_headless/recorder.h"

namespace plslam::viewer {

/// T_w_odom by frame.
using FrameCorrections = std::map<int64_t, SE3>;

/// What the map made of what odometry saw, at its keyframes, by session: T_w_kf * T_odom_kf^-1.
std::map<int64_t, FrameCorrections> CorrectionsBySession(const Map& map);

/// Poses of frames in the map as it is at the end: what odometry saw, corrected as the map corrected the keyframes
/// around.
class FinalPoses {
 public:
  FinalPoses(const Map& map, const Recorder& recorder);

  /// T_w_c of a frame. Between two keyframes of the session the corrections of both are applied and the results
  /// blended by the number of frames (translation on the straight line, rotation on the great arc), before the first
  /// and after the last the nearest is, and so it is on either side of frames that were lost, since nobody knows what
  /// lies between. A session that the map has nothing of keeps what was published.
  SE3 operator()(int64_t frame_id, const FrameRecord& frame) const;

 private:
  std::map<int64_t, FrameCorrections> corrections_;
  std::set<int64_t> lost_frames_;
};

/// T_w_c of the map's keyframes of recorded sessions, in the order of time.
Trajectory KeyframeTrajectory(const Map& map, const Recorder& recorder);

}  // namespace plslam::viewer
