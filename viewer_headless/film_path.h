// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "core/map/map.h"
#include "viewer_headless/final_trajectory.h"
#include "viewer_headless/recorder.h"

namespace plslam {

/// The path of a film so far. What was published stays where it was when the map is corrected, so that path and
/// landmarks would come apart: positions are kept as odometry saw them, and each moves with a keyframe.
class FilmPath {
 public:
  /// Frames without an estimated pose (HasPose) are no part of it.
  void Add(const FramePose& pose);

  /// Positions in w, in the map as it is now, in the order they came in. A frame moves as the last keyframe of its
  /// session up to it has been moved, or else the first one after; not across lost frames, since nobody knows what
  /// lies between. Where that leaves none the frame stays as published. (FinalPoses, which know what comes next,
  /// blend between two keyframes: a path in a film would creep with each new one.)
  std::vector<Eigen::Vector3d> In(const Map& map) const;

 private:
  struct Step {
    int64_t frame_id = 0;
    int64_t session = 0;
    Eigen::Vector3d p_odom;
    Eigen::Vector3d p_w;  ///< as published
  };

  const SE3* CorrectionOf(const Step& step, const FrameCorrections& corrections) const;
  bool IsLostBetween(int64_t from, int64_t to) const;

  std::vector<Step> steps_;
  std::set<int64_t> lost_frames_;
};

}  // namespace plslam
