// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/run/tracking_state.h"
#include "vo_process/stereo/rolling_shutter.h"
#include "vo_process/stereo/stereo_front_end.h"
#include "vo_process/tracking/bodies/moving_bodies.h"
#include "vo_process/tracking/calibration/corner_budget.h"
#include "vo_process/tracking/calibration/disparity_calibration.h"
#include "vo_process/tracking/calibration/noise_scale.h"
#include "vo_process/tracking/calibration/row_calibration.h"
#include "vo_process/tracking/calibration/sync_check.h"
#include "vo_process/tracking/calibration/timing_check.h"
#include "vo_process/tracking/landmarks/keyframe_measurements.h"
#include "vo_process/tracking/landmarks/local_landmarks.h"
#include "vo_process/tracking/motion/frame_aligner.h"
#include "vo_process/tracking/motion/inertial_motion_model.h"
#include "vo_process/tracking/motion/keyframe_policy.h"
#include "vo_process/tracking/motion/motion_model.h"
#include "vo_process/tracking/motion/motion_uncertainty.h"
#include "vo_process/tracking/motion/robot_motion_model.h"

namespace plslam::vo {

/// A frame that became a keyframe: motion since the previous keyframe.
struct KeyframeStep {
  int64_t id = 0;
  KeyframeReason reason = KeyframeReason::kNone;
  /// -1 for the first; then the relative pose is identity with zero covariance.
  int64_t previous_id = -1;
  SE3 T_prevkf_kf;
  Matrix6d covariance = Matrix6d::Zero();
  /// Measurements of the frames since the last keyframe, expressed in this one, and their landmarks.
  KeyframeContent content;
  /// Landmarks of earlier keyframes that turned out to be on a moving body.
  std::vector<Withdrawn> withdrawn_points;
  std::vector<Withdrawn> withdrawn_lines;
};

/// Result of odometry for a frame.
struct OdometryResult {
  TrackingState state = TrackingState::kInitialising;
  /// Continuous over the session, identity at its first frame with features; the covariance of its right perturbation
  /// is composed of those of the motions.
  SE3 T_odom_c;
  Matrix6d covariance = Matrix6d::Zero();
  /// Motion since the previous frame; if the pose `jumped`, from the predicted pose of a lost camera to the recovered
  /// one.
  SE3 T_prev_c;
  bool jumped = false;
  /// Whether the frame was found where a relocalisation said.
  bool relocalised = false;
  /// Whether the pose is the inertial sensor's alone, because the frame showed no known landmarks.
  bool carried = false;
  /// Includes errors that frames have in common (`MotionUncertainty`).
  Matrix6d motion_covariance = Matrix6d::Zero();
  double entropy_ratio = 0.0;
  std::optional<KeyframeStep> keyframe;
  int n_tracked_points = 0;
  int n_tracked_lines = 0;
  /// Features on moving bodies, and bodies published so far.
  int n_moving = 0;
  int n_bodies = 0;
  std::vector<BodyPose> bodies;
  /// The frame's features and their landmarks.
  StereoFeatures features;
  std::vector<FeatureTrack> point_tracks;
  std::vector<FeatureTrack> line_tracks;
};

/// Covariance of the motion of a camera that saw nothing meanwhile: sigmas of 10 m and one radian.
Matrix6d UnknownMotion();

/// Stereo odometry with points and lines (PL-SLAM §IV): the state between frames, and the decisions. No clock, no
/// messages: features and time stamps in, poses and keyframes out, the same for the same input.
class Odometry {
 public:
  Odometry(const StereoCamera& camera, const VoOptions& options, const RollingShutter& shutter = {},
           const std::optional<MountedImu>& imu = {});

  const DisparityCalibration& disparity_calibration() const { return calibration_; }

  const SyncCheck& sync_check() const { return sync_check_; }

  /// Readout time of the rows that was found although the calibration states none; 0 until it is significant.
  double found_readout_s() const { return states_readout_ ? 0.0 : shutter_.readout_s(); }
  /// Readout time that the images show, if it contradicts the stated one significantly; 0 otherwise.
  double contradicting_readout_s() const;
  /// Distance that the camera moves while the rows of the last image are read.
  double PathOfReadout_m() const { return shutter_.readout_s() * last_velocity_.head<3>().norm(); }

  /// Starts with the self-calibration of another tracker with the same cameras; before the first frame.
  void Begin(const SelfCalibration& learned);
  SelfCalibration learned() const { return {row_calibration_.learned(), calibration_.learned()}; }

  /// Sets the robot's measured motion to the next frame; nullopt, or no call, if there is none.
  void ExpectRobot(const std::optional<RobotMotion>& motion) { robot_model_.Expect(motion); }
  /// Sets the samples of the inertial sensor since the last frame, which was at `from_ns`, to the next one.
  void ExpectImu(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns) {
    inertial_.Expect(samples, from_ns, to_ns);
  }
  const InertialMotionModel& inertial() const { return inertial_; }
  const RobotMotionModel& robot_model() const { return robot_model_; }

  /// Predicts the skew of the pair at this time, before it is processed.
  void Expect(int64_t t_ns);

  /// Estimated vertical disparity of the predicted pair.
  RowField rows() const { return row_calibration_.field().With(skew_); }

  /// Number of corners to detect in each image of the next pair.
  int max_points() const { return corner_budget_.max_points(); }

  /// Whether the vertical disparity is unknown: the next pair is then processed with a wide row tolerance.
  bool needs_rows() const { return row_calibration_.needs_look(); }

  /// Learns the vertical disparity from the matches of a pair, before it is tracked. Returns whether `rows` has become
  /// zero or nonzero; disparities before and after are then inconsistent.
  bool LearnRows(const StereoFeatures& features);

  /// Tracks the next frame; `t_ns` is sensor time. Frames without features, repeated frames and frames without matches
  /// return a state, and a pose predicted by the motion model.
  OdometryResult Track(int64_t t_ns, StereoFeatures features);

  /// Adopts the landmarks of the map around a keyframe of this session, and T_w_odom with them. Poses in odom do not
  /// jump; later frames are aligned with those landmarks. Returns false and does nothing if the map does not have the
  /// keyframe.
  bool Adopt(const Map& map, int64_t session, int64_t keyframe_id);

  /// Adopts the landmarks of a map that no longer grows, around the keyframe that observes most of those tracked in the
  /// last frame; T_w_odom stays. Returns false and does nothing if none of the map's landmarks was tracked.
  bool AdoptAround(const Map& map);

  /// Uses a relocalisation near a keyframe of the map, with this T_w_odom. The next frame is searched among the
  /// landmarks there, and `T_w_odom` is adopted if it is found. If the camera was lost, the motion in between becomes
  /// unknown; if not, odometry continues and T_w_odom absorbs the difference. Returns false and does nothing if the map
  /// does not have the keyframe.
  bool Relocalise(const Map& map, int64_t map_keyframe_id, const SE3& T_w_odom);

  /// Begins another session: the next tracked frame becomes its first keyframe. Landmarks and their poses in the map
  /// stay.
  void BeginSession();

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

  /// The state after a frame that became a keyframe, for `core/io/files/archive.h`. Such a frame was tracked, so there
  /// is no previous local map, and the measurements since the previous keyframe are contained in it.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.motion_model_, self.noise_scale_, self.keyframe_policy_, self.calibration_, self.row_calibration_,
      self.corner_budget_, self.sync_check_, self.landmarks_, self.bodies_, self.keyframe_log_, self.T_w_odom_,
      self.initialised_, self.last_t_ns_, self.T_odom_c_, self.tracked_weight_, self.alignment_covariance_,
      self.is_in_map_, self.is_unanchored_, self.next_keyframe_id_, self.T_odom_kf_, self.covariance_odom_kf_,
      self.covariance_kf_c_, self.alignment_covariance_kf_, self.keyframe_point_id_, self.keyframe_line_id_,
      self.uncertainty_, self.robot_model_, self.inertial_, self.has_last_velocity_, self.last_velocity_,
      self.timing_check_, self.shutter_);
  }

 private:
  /// Landmarks among which a frame was found: usually those of the previous frame; after a loss those of the previous
  /// local map, those of the map at the relocalised place, or those created by a lost frame, or while the inertial sensor carried the
  /// pose. A camera that was not lost
  /// is localised: found among both, and continues with those of the map.
  enum class Reference {
    kCurrent,
    kPreviousLocalMap,
    kRelocalised,
    kLocalised,
    kCreatedWhileLost,
    kCreatedWhileCarried
  };
  struct Tracked {
    Alignment alignment;
    Reference reference = Reference::kCurrent;
    /// kPreviousLocalMap: the last pose among these landmarks, and its time before the last frame.
    SE3 T_odom_before{};
    double before_s = 0.0;
    /// The pose by the other motion, if only geometry decided which of two is the world's.
    std::optional<RivalMotion> rival{};
  };
  /// Landmarks of the map around a relocalisation result.
  struct Relocalised {
    LocalLandmarks landmarks;
    SE3 T_w_odom;
  };

  double SecondsSince(int64_t t_ns) const;
  MotionPrediction Predict(double dt_s) const;
  TrackedFrame Prepare(StereoFeatures features) const;
  void Follow(double dt_s, TrackedFrame& frame, OdometryResult& result);
  void FillKeyframe(const TrackedFrame& frame, OdometryResult& result);
  std::optional<Tracked> Find(const TrackedFrame& frame, const MotionPrediction& prediction);
  std::optional<Tracked> FindInPreviousLocalMap(const TrackedFrame& frame, const MotionPrediction& prediction);
  std::optional<Tracked> FindRelocalised(const TrackedFrame& frame, const MotionPrediction& prediction);
  bool KeepOdometry(const TrackedFrame& frame, const MotionPrediction& prediction, Alignment& found,
                    Relocalised& place) const;
  int ExpectedWeight() const;
  void MoveToStamp(const Vector6d& velocity, TrackedFrame& frame);
  void EstimateVelocity(double dt_s, Tracked& tracked, TrackedFrame& frame);
  void UseFirstVelocity(const SE3& T_prev_c, double dt_s, TrackedFrame& frame);
  void SeparateBodies(Tracked& tracked, const MotionPrediction& prediction, double dt_s, TrackedFrame& frame);
  void Accept(const Tracked& tracked, double dt_s, TrackedFrame& frame, OdometryResult& result);
  void LearnAboutRobot(double dt_s, const OdometryResult& result);
  void LearnMotion(const Tracked& tracked, double dt_s, const Matrix6d& covariance_before,
                   const OdometryResult& result);
  void PropagateCovariance(const Tracked& tracked, OdometryResult& result);
  void PublishCovariance(OdometryResult& result);
  void Carry(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame, OdometryResult& result);
  void Miss(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame, OdometryResult& result);
  void CalibrateDisparities(TrackedFrame& frame);
  void CheckSync(TrackedFrame& frame, const SE3& T_prev_c, double dt_s);
  void CheckTiming(TrackedFrame& frame, const OdometryResult& result, double dt_s);
  void UseFoundReadout(const Vector6d& velocity, TrackedFrame& frame);
  void Initialise(TrackedFrame& frame, OdometryResult& result);
  void ChooseKeyframe(const Tracked& tracked, const TrackedFrame& frame, OdometryResult& result);
  void MakeKeyframe(KeyframeReason reason, OdometryResult& result);
  int TrackedFromKeyframe(const TrackedFrame& frame) const;

  StereoCamera camera_;
  VoOptions options_;
  FrameAligner aligner_;
  MotionModel motion_model_;
  RobotMotionModel robot_model_;
  InertialMotionModel inertial_;
  /// Frames in a row whose pose the inertial sensor carried, and whether one of them created landmarks.
  int n_carried_ = 0;
  bool created_while_carried_ = false;
  MotionUncertainty uncertainty_;
  NoiseScale noise_scale_;
  KeyframePolicy keyframe_policy_;
  DisparityCalibration calibration_;
  RowCalibration row_calibration_;
  CornerBudget corner_budget_;
  SyncCheck sync_check_;
  TimingCheck timing_check_;
  RollingShutter shutter_;
  /// The frame being tracked, if its rows are not simultaneous.
  std::optional<RollingFrame> rolling_;
  bool states_readout_ = false;
  /// Mean velocity over the last interval, if both its frames were tracked.
  bool has_last_velocity_ = false;
  Vector6d last_velocity_ = Vector6d::Zero();
  /// Skew of the predicted pair.
  PairSkew skew_;
  LocalLandmarks landmarks_;
  MovingBodies bodies_;
  KeyframeLog keyframe_log_;
  KeyframeMeasurements keyframe_measurements_;
  SE3 T_w_odom_;

  bool initialised_ = false;
  int64_t last_t_ns_ = 0;
  SE3 T_odom_c_;
  /// Inlier score of the last tracked frame (points + 2 x lines).
  int tracked_weight_ = 0;
  /// Covariance of the previous frame's T_odom_c given the landmarks.
  Matrix6d alignment_covariance_ = Matrix6d::Zero();

  /// While lost: the landmarks before the loss, and the last pose among them.
  struct PreviousLocalMap {
    LocalLandmarks landmarks;
    SE3 T_odom_c;
    int n_lost = 0;          ///< frames since the loss
    double elapsed_s = 0.0;  ///< time from the loss to the last frame
    bool by_robot = true;    ///< whether the robot's odometry covers all of these frames
  };
  std::optional<PreviousLocalMap> previous_local_map_;

  std::optional<Relocalised> relocalised_;
  bool is_in_map_ = false;
  bool is_unanchored_ = false;

  int64_t next_keyframe_id_ = 0;
  bool begins_session_ = false;  ///< the next tracked frame becomes a keyframe
  SE3 T_odom_kf_;
  /// Published covariances of the keyframe's pose and of the motion since.
  Matrix6d covariance_odom_kf_ = Matrix6d::Zero();
  Matrix6d published_kf_c_ = Matrix6d::Zero();
  /// Covariance of the camera's pose given the landmarks. Both ends were measured against these, so the motion between
  /// two keyframes is less certain than the pose of the next keyframe.
  Matrix6d covariance_kf_c_ = Matrix6d::Zero();
  Matrix6d alignment_covariance_kf_ = Matrix6d::Zero();
  Matrix6d covariance_between_keyframes_ = Matrix6d::Zero();
  /// Landmarks with smaller ids were known to the last keyframe.
  int64_t keyframe_point_id_ = 0;
  int64_t keyframe_line_id_ = 0;
};

/// Computes the stereo features of the next pair for `odometry.Track`, using and learning its vertical disparity. The
/// first pair is processed twice, because it creates landmarks: first for vertical disparities that may be large. So
/// are further pairs until enough was seen, and a pair that changes whether a vertical disparity is applied. Throws as
/// `StereoFrontEnd::Process`.
inline StereoFeatures SeePair(StereoFrontEnd& front_end, Odometry& odometry, const StereoImages& images,
                              StageTimer& timer) {
  odometry.Expect(images.t_ns);
  const bool looks = odometry.needs_rows();
  if (looks) timer.Time("rows", [&] { odometry.LearnRows(front_end.LookForRows(images, odometry.rows().skew())); });
  StereoFeatures features = front_end.Process(images, timer, odometry.rows(), odometry.max_points());
  if (!looks && odometry.LearnRows(features))
    features = front_end.Process(images, timer, odometry.rows(), odometry.max_points());
  return features;
}

}  // namespace plslam::vo
