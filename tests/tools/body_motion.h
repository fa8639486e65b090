// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"

namespace plslam::test {

/// The pasted body and its motion: names of `BodyKindNames`.
struct BodyRequest {
  std::string kind;
  double share =
      0.45;  ///< of the width of the image; overtake and oncoming scale with it, and have their real size at 0.45
  double depth_m = 0.0;  ///< where a vehicle ahead would be; 0: at a disparity of 4.5 % of the width
  uint64_t seed = 1;
};

/// A box and its pose in every frame.
struct MovingBox {
  Eigen::Vector3d size_m;
  std::vector<SE3> T_w_b;
};

/// - `lead`: a vehicle ahead that moves as fast as the camera, with a small motion of its own;
/// - `overtake`: a lorry that comes from behind on the left, passes close by and turns in ahead;
/// - `cross`: crosses from right to left while the camera drives on;
/// - `oncoming`: comes from ahead and passes on the left;
/// - `bus`: passes from right to left at one depth.
const std::vector<std::string>& BodyKindNames();

/// Returns the body for a camera on the path `T_w_c`. Its motion follows the smoothed path, so that shaking of the
/// camera does not shake it.
MovingBox MoveBody(const BodyRequest& request, const StereoCamera& camera, const std::vector<SE3>& T_w_c);

}  // namespace plslam::test
