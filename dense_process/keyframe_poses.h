// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/map/map.h"

namespace plslam::dense {

/// Session and frame of a keyframe: a name that stays when the map is rebuilt.
using KeyframeFrame = std::pair<SessionId, FrameId>;
using KeyframePoses = std::map<KeyframeFrame, SE3>;  ///< T_w_kf

/// Returns the poses of the keyframes of the map.
KeyframePoses LastingPosesOf(const Map& map);
/// The same, and of those that were removed if the map remembers them.
KeyframePoses PosesOf(const Map& map);

/// Returns the removed keyframes to forget if there are more than `most` of them: the oldest that are not `needed`, so
/// that nine tenths of `most` remain. `removed` ascends by id.
std::set<KeyframeId> RemovedToForget(const std::vector<RemovedKeyframe>& removed, size_t most,
                                     const std::set<KeyframeFrame>& needed);

/// Returns the keyframe nearest to `T_w_kf`; nullopt: there is none.
std::optional<KeyframeFrame> NearestKeyframe(const KeyframePoses& poses, const SE3& T_w_kf);

/// The part of a surface that keyframes see.
struct SeenSurface {
  double share = 0.0;                     ///< of its points, by any of them
  std::map<KeyframeFrame, int> n_points;  ///< by the keyframes that see some
};

/// Returns which points of w are in the images of keyframes, within `range_m`; whether others hide them is not
/// considered.
SeenSurface SeenBy(const KeyframePoses& poses, const StereoCamera& camera, double range_m,
                   std::span<const Eigen::Vector3d> points_w);

}  // namespace plslam::dense
