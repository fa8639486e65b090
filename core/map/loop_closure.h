// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/se3.h"
#include "core/ids/ids.h"
#include "core/ids/map_version.h"

namespace plslam {

/// A keyframe by its id, and its name, which stays when a map that is rebuilt after a crash assigns other ids.
struct NamedKeyframe {
  KeyframeId keyframe_id = -1;
  KeyframeName name;

  bool operator==(const NamedKeyframe&) const = default;
};

/// New pose of a keyframe of the map.
struct CorrectedPose {
  KeyframeId keyframe_id = -1;
  SE3 T_w_kf;
};

/// Two landmarks of the map that are the same.
struct SameLandmarks {
  LandmarkId a = -1;
  LandmarkId b = -1;

  bool operator==(const SameLandmarks&) const = default;
};

/// Two keyframes that see the same place, and their relative pose (PL-SLAM §VI.A.2) with the covariance of the right
/// perturbation of T_old_kf. A permanent edge of the pose graph.
struct LoopEdge {
  KeyframeId old_keyframe_id = -1;
  KeyframeId keyframe_id = -1;
  SE3 T_old_kf;
  Matrix6d covariance = Matrix6d::Zero();
  int32_t n_points = 0;  ///< inliers of each feature type
  int32_t n_lines = 0;

  bool EndsAt(KeyframeId id) const { return old_keyframe_id == id || keyframe_id == id; }
};

/// Result of loop_process for a keyframe; the content of `loop_closure_t`. Each keyframe that enters the map gets one,
/// in order, most of them kNone.
struct LoopClosure {
  enum class Kind {
    kNone = 0,        ///< no loop was detected at this keyframe
    kLoop = 1,        ///< a loop, and the poses of the keyframes after closing it (pose graph)
    kAdjustment = 2,  ///< the poses after the global bundle adjustment that followed a loop
  };

  SourceId source;  ///< publisher; set by the receiver
  Kind kind = Kind::kNone;
  /// The keyframe, and its time.
  KeyframeName keyframe;
  int64_t t_ns = 0;
  /// The map on which it was computed.
  std::optional<MapVersion> map_version;
  /// Whether another message about the same keyframe follows (an adjustment is running).
  bool more = false;
  /// One edge as a rule; only with `kLoop`.
  std::vector<LoopEdge> edges;
  /// Pairs of landmarks of both sides to fuse; only with `kLoop`.
  std::vector<SameLandmarks> points;
  std::vector<SameLandmarks> lines;
  /// Ascending by keyframe; keyframes that are not listed move with their parent in the spanning tree.
  std::vector<CorrectedPose> poses;
  /// Names of all keyframes in edges and poses, ascending by id.
  std::vector<NamedKeyframe> names;
  /// For reports: similarity of the images, and times in ms: of a check without a result, or of detecting a loop and
  /// computing the correction.
  double score = 0.0;
  double detect_ms = 0.0;
  double correct_ms = 0.0;
};

/// The result of a tracker's relocalisation request; the content of `relocalisation_t`.
struct Relocalisation {
  SourceId source;  ///< publisher; set by the receiver
  /// The request: session, frame and time.
  SessionId session;
  FrameId frame_id = -1;
  int64_t t_ns = 0;
  bool found = false;
  /// The map in which it was found, the keyframe of the recognised place, and the pose with the covariance of its right
  /// perturbation given the landmarks.
  std::optional<MapVersion> map_version;
  KeyframeId keyframe_id = -1;
  SE3 T_w_c;
  Matrix6d covariance = Matrix6d::Zero();
  int32_t n_points = 0;  ///< inliers of each feature type
  int32_t n_lines = 0;
};

}  // namespace plslam
