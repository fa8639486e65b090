#pragma once

#include "core/io/trajectory.h"
#include "core/map/map.h"
#include "viewer_headless/recorder.h"

namespace plslam {

/// Poses of frames in the map as it is at the end: what odometry saw, corrected as the map corrected the keyframes around.
class FinalPoses {
 public:
  FinalPoses(const Map& map, const Recorder& recorder);

  /// T_w_c of a frame. The correction of a keyframe is T_w_kf * T_odom_kf^-1; between two keyframes of the session both
  /// are applied and the results blended by the number of frames (translation on the straight line, rotation on the
  /// great arc), before the first and after the last the nearest is, and so it is on either side of frames that were lost, since
  /// nobody knows what lies between. A session that the map has nothing of keeps what was published.
  SE3 operator()(int64_t frame_id, const FrameRecord& frame) const;

 private:
  /// T_w_odom by frame, by session.
  std::map<int64_t, std::map<int64_t, SE3>> corrections_;
  std::set<int64_t> lost_frames_;
};

/// T_w_c of the map's keyframes of recorded sessions, in the order of time.
Trajectory KeyframeTrajectory(const Map& map, const Recorder& recorder);

}  // namespace plslam
