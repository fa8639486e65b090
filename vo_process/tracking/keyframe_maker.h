// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/map/map.h"
#include "vo_process/options.h"
#include "vo_process/tracking/landmarks/keyframe_measurements.h"
#include "vo_process/tracking/landmarks/local_landmarks.h"
#include "vo_process/tracking/landmarks/tracker_local_map.h"
#include "vo_process/tracking/motion/keyframe_policy.h"
#include "vo_process/tracking/odometry_result.h"

namespace plslam::vo {

/// Decides which frames become keyframes (PL-SLAM §IV.D), and makes them. Keyframes of a session are numbered from 0.
class KeyframeMaker {
 public:
  KeyframeMaker(const StereoCamera& camera, const KeyframeOptions& options);

  /// Begins another session with the next tracked frame as its first keyframe.
  void BeginSession();
  bool begins_session() const { return begins_session_; }

  /// Motion since the last keyframe.
  SE3 SinceKeyframe(const SE3& T_odom_c) const { return T_odom_kf_.Inverse() * T_odom_c; }

  /// Decides whether a tracked frame becomes a keyframe. `covariance` is that of the motion since the last keyframe;
  /// `map_grows`: many landmarks that the map knows well are a reason against a keyframe.
  KeyframeDecision Decide(const TrackedFrame& frame, const SE3& T_odom_c, const Matrix6d& covariance, bool map_grows);

  /// Makes the keyframe, without its content. `covariance` is that of the motion since the previous one.
  KeyframeStep Make(KeyframeReason reason, const SE3& T_odom_c, const Matrix6d& covariance,
                    const LocalLandmarks& landmarks);

  /// Adds the measurements of a frame that was tracked, a keyframe included.
  void Add(const SE3& T_odom_c, const TrackedFrame& frame);
  /// Discards measurements that are found to be displaced.
  void ForgetMeasurements() { measurements_ = KeyframeMeasurements(camera_); }
  /// Returns the content of the keyframe that was made from the last added frame: its measurements and those since the
  /// previous keyframe.
  KeyframeContent TakeContent(int64_t keyframe_id, const TrackedFrame& frame, const LocalLandmarks& landmarks);

  /// Returns the landmarks of the map around a keyframe, as in `KeyframeLog`.
  std::optional<TrackerLocalMap> LocalMapAround(const Map& map, const KeyframeName& keyframe,
                                                int max_keyframes) const {
    return log_.LocalMapAround(map, keyframe, max_keyframes);
  }

  /// The state after a keyframe, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.policy_, self.log_, self.next_id_, self.T_odom_kf_, self.first_unknown_point_, self.first_unknown_line_);
  }

 private:
  int TrackedFromKeyframe(const TrackedFrame& frame) const;

  StereoCamera camera_;
  KeyframeOptions options_;
  KeyframePolicy policy_;
  KeyframeMeasurements measurements_;
  KeyframeLog log_;
  int64_t next_id_ = 0;
  bool begins_session_ = false;
  SE3 T_odom_kf_;
  /// Landmarks with smaller ids were known to the last keyframe.
  TrackId first_unknown_point_ = 0;
  TrackId first_unknown_line_ = 0;
};

}  // namespace plslam::vo
