// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "vo_process/options.h"
#include "vo_process/stereo/rolling_shutter.h"
#include "vo_process/stereo/stereo_front_end.h"
#include "vo_process/tracking/bodies/moving_bodies.h"
#include "vo_process/tracking/calibration/self_calibrator.h"
#include "vo_process/tracking/follow_policy.h"
#include "vo_process/tracking/keyframe_maker.h"
#include "vo_process/tracking/landmarks/local_landmarks.h"
#include "vo_process/tracking/motion/frame_aligner.h"
#include "vo_process/tracking/motion/motion_predictor.h"
#include "vo_process/tracking/odometry_result.h"
#include "vo_process/tracking/published_covariance.h"
#include "vo_process/tracking/recovery.h"

namespace plslam::vo {

/// Stereo odometry with points and lines (PL-SLAM §IV): the state between frames, and the order of the steps. No clock,
/// no messages: features and time stamps in, poses and keyframes out, the same for the same input.
///
/// For each frame: `ExpectRobot` and `ExpectImu`, if there are such sensors; `SeePair`; `Track`.
class Odometry {
 public:
  Odometry(const StereoCamera& camera, const VoOptions& options, const RollingShutter& shutter = {},
           const std::optional<MountedImu>& imu = {});

  /// Starts with the self-calibration of another tracker with the same cameras; before the first frame.
  void Begin(const SelfCalibration& learned) { calibrator_.Begin(learned); }
  const SelfCalibrator& calibration() const { return calibrator_; }

  /// Sets the robot's measured motion to the next frame; nullopt, or no call, if there is none.
  void ExpectRobot(const std::optional<RobotMotion>& motion) { motion_.ExpectRobot(motion); }
  /// Sets the samples of the inertial sensor since the last frame, which was at `from_ns`, to the next one.
  void ExpectImu(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns) {
    motion_.ExpectImu(samples, from_ns, to_ns);
  }
  const MotionPredictor& motion() const { return motion_; }

  /// Computes the stereo features of the next pair for `Track`, as `SelfCalibrator::SeePair`.
  StereoFeatures SeePair(StereoFrontEnd& front_end, const StereoImages& images, StageTimer& timer);

  /// Tracks the next frame; `t_ns` is sensor time. Frames without features, repeated frames and frames without matches
  /// return a state, and a pose predicted by the motion model.
  OdometryResult Track(int64_t t_ns, StereoFeatures features);

  /// Adopts the landmarks of the map around a keyframe of this session, and T_w_odom with them. Poses in odom do not
  /// jump; later frames are aligned with those landmarks. Returns false and does nothing if the map does not have the
  /// keyframe.
  bool Adopt(const Map& map, const KeyframeName& keyframe);

  /// Adopts the landmarks of a map that no longer grows, around the keyframe that observes most of those tracked in the
  /// last frame; T_w_odom stays. Returns false and does nothing if none of the map's landmarks was tracked.
  bool AdoptAround(const Map& map);

  /// Uses a relocalisation near a keyframe of the map, with this T_w_odom. The next frame is searched among the
  /// landmarks there, and `T_w_odom` is adopted if it is found. If the camera was lost, the motion in between becomes
  /// unknown; if not, odometry continues and T_w_odom absorbs the difference. Returns false and does nothing if the map
  /// does not have the keyframe.
  bool Relocalise(const Map& map, KeyframeId map_keyframe_id, const SE3& T_w_odom);

  /// Begins another session: the next tracked frame becomes its first keyframe. Landmarks and their poses in the map
  /// stay.
  void BeginSession() {
    keyframes_.BeginSession();
    following_.RequireDetection();
  }

  /// In localisation-only mode, keyframes only adopt the local map (`MapUseOptions::localise_only`).
  void SetLocaliseOnly(bool localise_only) { options_.map.localise_only = localise_only; }
  bool localise_only() const { return options_.map.localise_only; }

  /// Whether the camera was found in a map, by `Adopt` or `Relocalise`.
  bool is_in_map() const { return is_in_map_; }

  /// Whether tracking resumed after a loss, but not at the place of the loss, so that its pose in the map is unknown.
  bool is_unanchored() const { return is_unanchored_; }

  /// Pose of the last frame.
  const SE3& T_odom_c() const { return T_odom_c_; }

  /// Pose of odom in the map, as of the last `Adopt`.
  const SE3& T_w_odom() const { return T_w_odom_; }

  /// The state after a frame that became a keyframe, for `core/files/archive.h`. Such a frame was tracked, so there
  /// is no previous local map, and the measurements since the previous keyframe are contained in it.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.motion_, self.calibrator_, self.landmarks_, self.bodies_, self.recovery_, self.keyframes_,
      self.covariance_, self.tracker_, self.following_, self.initialised_, self.last_t_ns_, self.T_odom_c_,
      self.T_w_odom_, self.is_in_map_, self.is_unanchored_);
  }

 private:
  double SecondsSince(int64_t t_ns) const;
  bool IsFrameToFrame() const { return options_.tracking.reference == TrackingReference::kPreviousFrame; }

  bool MayFollow() const;

  // The steps of `Track`.
  void Initialise(TrackedFrame& frame, OdometryResult& result);
  std::optional<Tracked> Find(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame);
  void EstimateVelocity(double dt_s, Tracked& tracked, TrackedFrame& frame) const;
  void SeparateBodies(Tracked& tracked, const MotionPrediction& prediction, double dt_s, TrackedFrame& frame);
  void UseInertial(const TrackedFrame& frame, Tracked& tracked) const;
  void Accept(const Tracked& tracked, double dt_s, OdometryResult& result);
  void UpdateLandmarks(const Tracked& tracked, TrackedFrame& frame, OdometryResult& result);
  void ChooseKeyframe(const Tracked& tracked, const TrackedFrame& frame, OdometryResult& result);
  void Calibrate(const Tracked& tracked, double dt_s, TrackedFrame& frame, const OdometryResult& result);
  void Carry(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame, OdometryResult& result);
  void Miss(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame, OdometryResult& result);
  void Publish(const std::optional<Tracked>& tracked, double dt_s, OdometryResult& result);
  OdometryResult Completed(TrackedFrame frame, OdometryResult result);

  void LearnVelocity(const Tracked& tracked, double dt_s, const Matrix6d& covariance_before,
                     const OdometryResult& result);
  void Predict(const MotionPrediction& prediction, double dt_s, OdometryResult& result);
  void MakeKeyframe(KeyframeReason reason, OdometryResult& result);
  void CreateLandmarksAgain(TrackedFrame& frame);

  StereoCamera camera_;
  VoOptions options_;
  FrameAligner aligner_;
  MotionPredictor motion_;
  SelfCalibrator calibrator_;
  LocalLandmarks landmarks_;
  MovingBodies bodies_;
  Recovery recovery_;
  KeyframeMaker keyframes_;
  PublishedCovariance covariance_;

  FeatureTracker tracker_;
  FollowPolicy following_;
  bool initialised_ = false;
  int64_t last_t_ns_ = 0;
  SE3 T_odom_c_;
  SE3 T_w_odom_;
  bool is_in_map_ = false;
  bool is_unanchored_ = false;
};

}  // namespace plslam::vo
