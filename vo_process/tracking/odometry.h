// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/run/tracking_state.h"
#include "vo_process/stereo/stereo_front_end.h"
#include "vo_process/tracking/corner_budget.h"
#include "vo_process/tracking/disparity_calibration.h"
#include "vo_process/tracking/frame_aligner.h"
#include "vo_process/tracking/keyframe_measurements.h"
#include "vo_process/tracking/keyframe_policy.h"
#include "vo_process/tracking/local_landmarks.h"
#include "vo_process/tracking/motion_model.h"
#include "vo_process/tracking/motion_uncertainty.h"
#include "vo_process/tracking/moving_bodies.h"
#include "vo_process/tracking/noise_scale.h"
#include "vo_process/tracking/robot_motion_model.h"
#include "vo_process/tracking/row_calibration.h"
#include "vo_process/tracking/sync_check.h"

namespace plslam::vo {

/// A frame that became a keyframe: motion since the one before.
struct KeyframeStep {
  int64_t id = 0;
  KeyframeReason reason = KeyframeReason::kNone;
  /// -1 for the first; then the relative pose is identity with zero covariance.
  int64_t previous_id = -1;
  SE3 T_prevkf_kf;
  Matrix6d covariance = Matrix6d::Zero();
  /// What the frames since the last keyframe saw, as seen from this one, and the landmarks it belongs to.
  KeyframeContent content;
  /// Landmarks that keyframes before this one have shown and that turned out to be of a moving body.
  std::vector<Withdrawn> withdrawn_points;
  std::vector<Withdrawn> withdrawn_lines;
};

/// What odometry says of a frame.
struct OdometryResult {
  TrackingState state = TrackingState::kInitialising;
  /// Continuous over the session, identity at its first frame with features; covariance of the right perturbation,
  /// which is composed of those of the motions.
  SE3 T_odom_c;
  Matrix6d covariance = Matrix6d::Zero();
  /// Motion since the frame before; where the pose `jumped`, from where a lost camera was thought to be to where it
  /// was found.
  SE3 T_prev_c;
  bool jumped = false;
  /// With what frames have in common (`MotionUncertainty`).
  Matrix6d motion_covariance = Matrix6d::Zero();
  double entropy_ratio = 0.0;
  std::optional<KeyframeStep> keyframe;
  int n_tracked_points = 0;
  int n_tracked_lines = 0;
  /// Features on moving bodies, and bodies met so far.
  int n_moving = 0;
  int n_bodies = 0;
  std::vector<BodyPose> bodies;
  /// The frame's features with the landmarks they belong to.
  StereoFeatures features;
  std::vector<FeatureTrack> point_tracks;
  std::vector<FeatureTrack> line_tracks;
};

/// Covariance of where a camera was carried while it saw nothing: 10 m and a radian.
Matrix6d UnknownMotion();

/// Stereo odometry with points and lines (PL-SLAM §IV): the state between frames, and the decisions. No clock, no
/// messages: features and time stamps in, poses and keyframes out, the same for the
/// same input.
class Odometry {
 public:
  Odometry(const StereoCamera& camera, const VoOptions& options);

  const DisparityCalibration& disparity_calibration() const { return calibration_; }

  const SyncCheck& sync_check() const { return sync_check_; }

  /// Begins with what another tracker has learned of the same cameras; before the first frame.
  void Begin(const SelfCalibration& learned);
  SelfCalibration learned() const { return {row_calibration_.learned(), calibration_.learned()}; }

  /// Before the next frame: how the robot says that it has moved since the last one; nullopt, or not called: nothing.
  void ExpectRobot(const std::optional<RobotMotion>& motion) { robot_model_.Expect(motion); }
  const RobotMotionModel& robot_model() const { return robot_model_; }

  /// Before the pair of this time is looked at: what it is expected to be like.
  void Expect(int64_t t_ns);

  /// How rows of the right image differ from those of the left one in the pair that is expected, as far as is known.
  RowField rows() const { return row_calibration_.field().With(skew_); }

  /// How many corners are wanted of each image of the next pair.
  int max_points() const { return corner_budget_.max_points(); }

  /// Nothing is known of them yet: the next pair is to be looked at with that in mind.
  bool needs_rows() const { return row_calibration_.needs_look(); }

  /// Learns how they differ from the matches of a pair, before it is tracked. True where `rows` becomes zero by it,
  /// or is not zero any more; the disparities of before are then others than those that come.
  bool LearnRows(const StereoFeatures& features);

  /// Takes the next frame; `t_ns` of sensor time. Frames without features, repeated frames and frames that match
  /// nothing are answered with a state, and the pose goes on by the motion model.
  OdometryResult Track(int64_t t_ns, StereoFeatures features);

  /// Takes over the landmarks of the map around a keyframe of this session, and with them T_w_odom. Poses in odom do
  /// not jump; from the next frame on they are found among those landmarks. False, and nothing done, where the map
  /// does not have the keyframe.
  bool Adopt(const Map& map, int64_t session, int64_t keyframe_id);

  /// Takes over the landmarks of a map that no longer grows, around the keyframe that sees most of those tracked in
  /// the last frame; T_w_odom stays. False, and nothing done, where none of the map was tracked.
  bool AdoptAround(const Map& map);

  /// Somebody has found the camera in the map: near a keyframe of it, with this T_w_odom. From the next frame on it
  /// is looked for among the landmarks there, and once it is found, `T_w_odom` is taken over. Where the camera had
  /// lost its way, what lies between is then as good as unknown; where it had not, odometry goes on as it did and
  /// T_w_odom takes the difference. False, and nothing done, where the map does not have the keyframe.
  bool Relocalise(const Map& map, int64_t map_keyframe_id, const SE3& T_w_odom);

  /// Keyframes are for another session from now on: the next frame that is found is its first. Landmarks stay, and so
  /// does where they are in the map.
  void BeginSession();

  /// Whether keyframes are only where the map is looked at anew (`MapUseOptions::localise_only`).
  void SetLocaliseOnly(bool localise_only) { options_.map.localise_only = localise_only; }
  bool localise_only() const { return options_.map.localise_only; }

  /// The camera has been found in a map, by `Adopt` or `Relocalise`.
  bool is_in_map() const { return is_in_map_; }

  /// Tracking went on after a loss, but not at the place where it was lost: where that is, nobody knows.
  bool is_unanchored() const { return is_unanchored_; }

  /// Pose of the last frame.
  const SE3& T_odom_c() const { return T_odom_c_; }

  /// Map from odometry, as of the last `Adopt`.
  const SE3& T_w_odom() const { return T_w_odom_; }

  /// All that it goes on with after a frame that became a keyframe, for `core/io/files/archive.h`. Such a frame was
  /// found, so nothing is lost or set aside then, and what was seen since the keyframe before has gone into it.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.motion_model_, self.noise_scale_, self.keyframe_policy_, self.calibration_, self.row_calibration_,
      self.corner_budget_, self.sync_check_, self.landmarks_, self.bodies_, self.keyframe_log_, self.T_w_odom_,
      self.initialised_, self.last_t_ns_, self.T_odom_c_, self.tracked_weight_, self.alignment_covariance_,
      self.is_in_map_, self.is_unanchored_, self.next_keyframe_id_, self.T_odom_kf_, self.covariance_odom_kf_,
      self.covariance_kf_c_, self.alignment_covariance_kf_, self.keyframe_point_id_, self.keyframe_line_id_,
      self.uncertainty_, self.robot_model_);
  }

 private:
  /// Where a frame was found: usually among the landmarks of the frame before; after it was lost, among those from
  /// before the loss, those of the map where it was relocalised, or those created by a lost frame. One that was not
  /// lost is localised: found among both, and goes on among those of the map.
  enum class Reference { kCurrent, kPreviousLocalMap, kRelocalised, kLocalised, kCreatedWhileLost };
  struct Tracked {
    Alignment alignment;
    Reference reference = Reference::kCurrent;
    /// kPreviousLocalMap: where the camera was when it was last seen among these landmarks, and how long before the
    /// last frame.
    SE3 T_odom_before{};
    double before_s = 0.0;
    /// Where only geometry said which of two motions is the world's: the pose by the other.
    std::optional<RivalMotion> rival{};
  };
  /// Landmarks of the map among which the camera should be.
  struct Relocalised {
    LocalLandmarks landmarks;
    SE3 T_w_odom;
  };

  double SecondsSince(int64_t t_ns) const;
  MotionPrediction Predict(double dt_s) const;
  std::optional<Tracked> Find(const TrackedFrame& frame, const MotionPrediction& prediction);
  std::optional<Tracked> FindInPreviousLocalMap(const TrackedFrame& frame, const MotionPrediction& prediction);
  std::optional<Tracked> FindRelocalised(const TrackedFrame& frame, const MotionPrediction& prediction);
  bool KeepOdometry(const TrackedFrame& frame, const MotionPrediction& prediction, Alignment& found,
                    Relocalised& place) const;
  int ExpectedWeight() const;
  void TellBodiesApart(Tracked& tracked, const MotionPrediction& prediction, double dt_s, TrackedFrame& frame);
  void Accept(const Tracked& tracked, double dt_s, TrackedFrame& frame, OdometryResult& result);
  void LearnAboutRobot(double dt_s, const OdometryResult& result);
  void LearnMotion(const Tracked& tracked, double dt_s, const Matrix6d& covariance_before,
                   const OdometryResult& result);
  void PropagateCovariance(const Tracked& tracked, OdometryResult& result);
  void PublishCovariance(OdometryResult& result);
  void Miss(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame, OdometryResult& result);
  void CalibrateDisparities(TrackedFrame& frame, const std::vector<double>& raw_disparities_px);
  void CheckSync(TrackedFrame& frame, const SE3& T_prev_c, double dt_s);
  void Initialise(TrackedFrame& frame, OdometryResult& result);
  void ChooseKeyframe(const Tracked& tracked, const TrackedFrame& frame, OdometryResult& result);
  void MakeKeyframe(KeyframeReason reason, OdometryResult& result);
  int TrackedFromKeyframe(const TrackedFrame& frame) const;

  StereoCamera camera_;
  VoOptions options_;
  FrameAligner aligner_;
  MotionModel motion_model_;
  RobotMotionModel robot_model_;
  MotionUncertainty uncertainty_;
  NoiseScale noise_scale_;
  KeyframePolicy keyframe_policy_;
  DisparityCalibration calibration_;
  RowCalibration row_calibration_;
  CornerBudget corner_budget_;
  SyncCheck sync_check_;
  /// Of the pair that is expected.
  PairSkew skew_;
  LocalLandmarks landmarks_;
  MovingBodies bodies_;
  KeyframeLog keyframe_log_;
  KeyframeMeasurements keyframe_measurements_;
  SE3 T_w_odom_;

  bool initialised_ = false;
  int64_t last_t_ns_ = 0;
  SE3 T_odom_c_;
  /// Inliers of the last frame that was found (points + 2 x lines).
  int tracked_weight_ = 0;
  /// Of T_odom_c given the landmarks, at the frame before.
  Matrix6d alignment_covariance_ = Matrix6d::Zero();

  /// While lost: the landmarks from before, and where the camera was then.
  struct PreviousLocalMap {
    LocalLandmarks landmarks;
    SE3 T_odom_c;
    int n_lost = 0;          ///< frames since
    double elapsed_s = 0.0;  ///< up to the last of them
    bool by_robot = true;    ///< the robot has told the motion of all of them
  };
  std::optional<PreviousLocalMap> previous_local_map_;

  std::optional<Relocalised> relocalised_;
  bool is_in_map_ = false;
  bool is_unanchored_ = false;

  int64_t next_keyframe_id_ = 0;
  bool begins_session_ = false;  ///< the next frame that is found is a keyframe
  SE3 T_odom_kf_;
  /// As published, of the keyframe and of the motion since.
  Matrix6d covariance_odom_kf_ = Matrix6d::Zero();
  Matrix6d published_kf_c_ = Matrix6d::Zero();
  /// Of where the camera is, given the landmarks as they are. Both ends were measured against these, so the motion
  /// between two keyframes is less sure than the next keyframe is.
  Matrix6d covariance_kf_c_ = Matrix6d::Zero();
  Matrix6d alignment_covariance_kf_ = Matrix6d::Zero();
  Matrix6d covariance_between_keyframes_ = Matrix6d::Zero();
  /// Landmarks with smaller ids were known to the last keyframe.
  int64_t keyframe_point_id_ = 0;
  int64_t keyframe_line_id_ = 0;
};

/// Stereo features of the next pair, for `odometry.Track`, with rows that differ as they are known to; what the pair
/// tells of them is learned. The first pair is looked at twice, since landmarks are created on it: before all for
/// rows that may differ by much. So are further ones until there was enough to see, and one that changes whether rows
/// differ. Throws as `StereoFrontEnd::Process`.
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
