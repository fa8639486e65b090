// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/se3.h"

namespace plslam {

/// Which keyframe of a map an id means: a map that is built anew after a crash may give other ids, but sessions and
/// their numbers stay.
struct KeyframeName {
  int64_t keyframe_id = -1;
  int64_t session = 0;
  int64_t session_keyframe_id = -1;

  bool operator==(const KeyframeName&) const = default;
};

/// Where a keyframe of the map should be.
struct CorrectedPose {
  int64_t keyframe_id = -1;
  SE3 T_w_kf;
};

/// Two landmarks of the map that are one.
struct SameLandmarks {
  int64_t a = -1;
  int64_t b = -1;

  bool operator==(const SameLandmarks&) const = default;
};

/// Two keyframes that see the same place, and how they lie to each other (PL-SLAM §VI.A.2); covariance of the right
/// perturbation of T_old_kf. An edge of the pose graph that stays.
struct LoopEdge {
  int64_t old_keyframe_id = -1;
  int64_t keyframe_id = -1;
  SE3 T_old_kf;
  Matrix6d covariance = Matrix6d::Zero();
  int32_t n_points = 0;  ///< inliers of each feature type
  int32_t n_lines = 0;
};

/// What loop_process says about a keyframe; the content of `loop_closure_t`. Every keyframe that came into the map is
/// answered, in order, most of them with kNone.
struct LoopClosure {
  enum class Kind {
    kNone = 0,        ///< no loop: the map is right as it is, as far as this keyframe tells
    kLoop = 1,        ///< a loop, and where the keyframes lie when it is closed (pose graph)
    kAdjustment = 2,  ///< where they lie after bundle adjustment of the whole map that followed a loop
  };

  int64_t source = 0;  ///< publisher; set by the receiver
  Kind kind = Kind::kNone;
  /// The keyframe it is about, as its session counts, and its time.
  int64_t session = 0;
  int64_t session_keyframe_id = -1;
  int64_t t_ns = 0;
  /// The map it was computed on.
  int64_t map_source = 0;
  int64_t map_version = 0;
  /// Another message about the same keyframe follows (an adjustment is under way).
  bool more = false;
  /// kLoop only; usually one.
  std::vector<LoopEdge> edges;
  /// kLoop only: landmarks of both sides that were found to be the same.
  std::vector<SameLandmarks> points;
  std::vector<SameLandmarks> lines;
  /// Ascending by keyframe; those that are not named move with the one they hang on in the spanning tree.
  std::vector<CorrectedPose> poses;
  /// Of all keyframes that edges and poses speak of; ascending by id.
  std::vector<KeyframeName> names;
  /// For reports: similarity of the images, and time in ms: of finding nothing, or of finding a loop and
  /// computing the correction.
  double score = 0.0;
  double detect_ms = 0.0;
  double correct_ms = 0.0;
};

/// The answer to a tracker that asks where it is; the content of `relocalisation_t`.
struct Relocalisation {
  int64_t source = 0;  ///< publisher; set by the receiver
  /// Whose question it answers.
  int64_t session = 0;
  int64_t frame_id = -1;
  int64_t t_ns = 0;
  bool found = false;
  /// The map it was found in, the keyframe whose surroundings were recognised, and the pose with the covariance of
  /// its right perturbation given the landmarks.
  int64_t map_source = 0;
  int64_t map_version = 0;
  int64_t keyframe_id = -1;
  SE3 T_w_c;
  Matrix6d covariance = Matrix6d::Zero();
  int32_t n_points = 0;  ///< inliers of each feature type
  int32_t n_lines = 0;
};

}  // namespace plslam
