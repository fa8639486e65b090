#pragma once

#include <cstdint>

#include "core/geometry/se3.h"

namespace plslam {

/// The answer to a tracker that asks where it is; the content of `relocalisation_t`.
struct Relocalisation {
  int64_t source = 0;  ///< publisher; set by the receiver
  /// Whose question it answers.
  int64_t session = 0;
  int64_t frame_id = -1;
  int64_t t_ns = 0;
  bool found = false;
  /// The map it was found in, the keyframe whose surroundings were recognised, and the pose with the covariance of its
  /// right perturbation given the landmarks.
  int64_t map_source = 0;
  int64_t map_version = 0;
  int64_t keyframe_id = -1;
  SE3 T_w_c;
  Matrix6d covariance = Matrix6d::Zero();
  int32_t n_points = 0;  ///< inliers of each kind
  int32_t n_lines = 0;
};

}  // namespace plslam
