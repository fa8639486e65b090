// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/odometry.h"

#include <algorithm>
#include <map>
#include <utility>

#include "vo_process/tracking/landmarks/frame_figures.h"
#include "vo_process/tracking/motion/map_placement.h"

namespace plslam::vo {
namespace {

constexpr double kMinInterval_s = 1e-3;
// Longest interval between two observations of the same landmarks from which a velocity is computed.
constexpr double kLongestStep_s = 0.5;

Matrix6d SquareOf(const SE3& difference) {
  const Vector6d x = difference.Log();
  return x * x.transpose();
}

}  // namespace

Odometry::Odometry(const StereoCamera& camera, const VoOptions& options, const RollingShutter& shutter,
                   const std::optional<MountedImu>& imu)
    : camera_(camera),
      options_(options),
      aligner_(camera, options),
      motion_(imu),
      calibrator_(camera, options, shutter),
      landmarks_(camera, options),
      bodies_(camera, options, imu),
      recovery_(camera, options),
      keyframes_(camera, options.keyframes),
      tracker_(camera, options.stereo) {}

// Seconds since the last frame. Unsigned, because time stamps at both ends of their range would overflow.
double Odometry::SecondsSince(int64_t t_ns) const {
  const auto dt_ns = static_cast<int64_t>(static_cast<uint64_t>(t_ns) - static_cast<uint64_t>(last_t_ns_));
  return std::max(1e-9 * static_cast<double>(dt_ns), kMinInterval_s);
}

StereoFeatures Odometry::SeePair(StereoFrontEnd& front_end, const StereoImages& images, StageTimer& timer) {
  const double dt_s = SecondsSince(images.t_ns);
  const SE3 T_prev_c = initialised_ ? motion_.Predict(dt_s).T_prev_c : SE3();
  calibrator_.PredictSkew(T_prev_c, dt_s);
  front_end.Take(images, timer);
  if (MayFollow()) {
    front_end.SetDirt(calibrator_.lenses().Cells());
    StereoFeatures features = front_end.Follow(timer, calibrator_.rows(), T_odom_c_, T_odom_c_ * T_prev_c, tracker_);
    following_.ObserveShare(tracker_.Share());
    const bool suffices =
        tracker_.Share() >= FollowPolicy::kMinShare && tracker_.Weight() >= FollowPolicy::kMinWeight;
    if (suffices && calibrator_.Accepts(features)) {
      following_.Follow();
      return features;
    }
  }
  following_.Detect();
  StereoFeatures features = calibrator_.SeePair(front_end, timer);
  if (options_.tracking.front_end == FrontEnd::kSemiDirect) tracker_.Begin(front_end.pair().left, features);
  return features;
}

// Bodies move in another way than the camera's motion predicts. Frame to frame, each frame replaces all landmarks.
bool Odometry::MayFollow() const {
  return following_.MayFollow() && !tracker_.empty() && !bodies_.IsAnyThere() && !IsFrameToFrame() &&
         !calibrator_.NeedsDetection();
}

/// The steps of PL-SLAM §IV: prediction, estimation of the motion from landmarks found by projection (§IV.C), update of
/// the landmarks, and keyframe selection (§IV.D). Before that, moving bodies are separated from the world; after it,
/// self-calibration learns from the frame.
OdometryResult Odometry::Track(int64_t t_ns, StereoFeatures features) {
  const double dt_s = SecondsSince(t_ns);
  last_t_ns_ = t_ns;
  TrackedFrame frame = calibrator_.Prepare(std::move(features));
  frame.is_followed = following_.TakeIsFollowed();
  OdometryResult result;
  if (!initialised_) {
    Initialise(frame, result);
    return Completed(std::move(frame), std::move(result));
  }
  const MotionPrediction prediction = motion_.Predict(dt_s);
  std::optional<Tracked> tracked = Find(prediction, dt_s, frame);
  if (tracked) {
    EstimateVelocity(dt_s, *tracked, frame);
    SeparateBodies(*tracked, prediction.ForSearch(), dt_s, frame);
    UseInertial(frame, *tracked);
    Accept(*tracked, dt_s, result);
    UpdateLandmarks(*tracked, frame, result);
    ChooseKeyframe(*tracked, frame, result);
    Calibrate(*tracked, dt_s, frame, result);
  } else if (!recovery_.is_lost() && motion_.CanCarry()) {
    Carry(prediction, dt_s, frame, result);
  } else {
    Miss(prediction, dt_s, frame, result);
  }
  Publish(tracked, dt_s, result);
  return Completed(std::move(frame), std::move(result));
}

void Odometry::Initialise(TrackedFrame& frame, OdometryResult& result) {
  result.state = TrackingState::kInitialising;
  if (CreatableLandmarks(frame.features) < options_.tracking.weak_inliers) return;
  landmarks_.Create(T_odom_c_, frame);
  motion_.StartInertial(T_odom_c_);
  initialised_ = true;
  result.state = TrackingState::kTracking;
  MakeKeyframe(KeyframeReason::kFirst, result);
}

std::optional<Tracked> Odometry::Find(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame) {
  calibrator_.MoveToStamp(prediction.T_prev_c.Log() / dt_s, frame);
  const MotionPrediction for_search = prediction.ForSearch();
  return recovery_.Find({frame, T_odom_c_, for_search, motion_.knows_motion()}, landmarks_);
}

/// Estimates pose and velocity of a frame with a rolling shutter in turn: each needs the other.
void Odometry::EstimateVelocity(double dt_s, Tracked& tracked, TrackedFrame& frame) const {
  constexpr int kPasses = 2;
  if (!frame.rolling || tracked.is_first_motion || tracked.reference != Reference::kCurrent) return;
  Alignment& alignment = tracked.alignment;
  aligner_.SetDisparities(landmarks_, alignment, *frame.rolling);
  for (int pass = 0; pass < kPasses && !alignment.weak; ++pass) {
    const Vector6d mean = (T_odom_c_.Inverse() * alignment.T_odom_c).Log() / dt_s;
    frame.MoveToStamp(calibrator_.VelocityAfter(mean));
    const auto better = aligner_.Estimate(landmarks_, frame, alignment.matches, alignment.T_odom_c, std::nullopt);
    if (!better) break;
    alignment.T_odom_c = better->T_odom_c;
    alignment.covariance = better->covariance;
  }
}

void Odometry::SeparateBodies(Tracked& tracked, const MotionPrediction& prediction, double dt_s,
                              TrackedFrame& frame) {
  if (!tracked.ContinuesMotion()) {
    return bodies_.SeparateKnown(dt_s, motion_.inertial(), landmarks_, frame, tracked.alignment);
  }
  Separation separation = bodies_.Separate(T_odom_c_, prediction, dt_s, calibrator_.disparities(), motion_.inertial(),
                                           landmarks_, frame, tracked.alignment);
  tracked.rival = separation.rival;
  if (!separation.confirmed) return;
  tracked.reference = Reference::kConfirmedBody;
  tracked.confirmed = std::move(separation.confirmed);
}

/// Estimates the pose again with the inertial sensor's motion as a further measurement.
void Odometry::UseInertial(const TrackedFrame& frame, Tracked& tracked) const {
  Alignment& alignment = tracked.alignment;
  tracked.seen = {alignment.T_odom_c, alignment.covariance};
  if (tracked.reference != Reference::kCurrent || alignment.weak || tracked.rival) return;
  const auto prior = motion_.inertial().PriorFrom({T_odom_c_, covariance_.alignment()}, tracked.seen);
  if (prior) alignment = aligner_.WithPrior(landmarks_, frame, alignment, *prior);
}

/// Moves the camera to the pose that was found.
void Odometry::Accept(const Tracked& tracked, double dt_s, OdometryResult& result) {
  const Alignment& alignment = tracked.alignment;
  result.state = TrackingState::kTracking;
  if (alignment.weak || tracked.rival || calibrator_.sync().is_far_off()) result.state = TrackingState::kWeak;
  if (!tracked.ContinuesMotion()) result.state = TrackingState::kRecovered;
  result.relocalised = tracked.reference == Reference::kRelocalised;
  result.jumped = tracked.Jumped();
  result.T_prev_c = T_odom_c_.Inverse() * alignment.T_odom_c;
  result.n_tracked_points = static_cast<int>(alignment.matches.points.size());
  result.n_tracked_lines = static_cast<int>(alignment.matches.lines.size());
  recovery_.Expect(alignment.matches.Weight());
  // A camera that was recovered where it was lost is anchored in the map as it was before.
  if (tracked.reference == Reference::kCreatedWhileLost) is_unanchored_ = true;
  if (tracked.T_w_odom) {
    T_w_odom_ = *tracked.T_w_odom;
    is_in_map_ = true;
    is_unanchored_ = false;
  }
  T_odom_c_ = alignment.T_odom_c;
  const Matrix6d covariance_before = covariance_.alignment();
  result.motion_covariance =
      covariance_.Measure(tracked, result.T_prev_c, keyframes_.SinceKeyframe(T_odom_c_), IsFrameToFrame());
  LearnVelocity(tracked, dt_s, covariance_before, result);
}

// A jump is not a motion: the motion while lost gives the velocity if that was short; otherwise the velocity is
// unknown. A second image at the same time gives no velocity.
void Odometry::LearnVelocity(const Tracked& tracked, double dt_s, const Matrix6d& covariance_before,
                             const OdometryResult& result) {
  MotionModel& velocity = motion_.velocity();
  if (!result.jumped) {
    if (dt_s > kMinInterval_s) velocity.Observe(result.T_prev_c, dt_s, result.motion_covariance);
    return;
  }
  if (tracked.confirmed) {
    velocity = tracked.confirmed->motion;
    return;
  }
  const double unseen_s = tracked.before_s + dt_s;
  if (tracked.reference != Reference::kPreviousLocalMap || unseen_s > kLongestStep_s) return velocity.Forget();
  const SE3 T_before_c = tracked.T_odom_before.Inverse() * tracked.alignment.T_odom_c;
  velocity.Observe(T_before_c, unseen_s,
                   ComposeCovariance(covariance_before, T_before_c, tracked.alignment.covariance));
}

void Odometry::UpdateLandmarks(const Tracked& tracked, TrackedFrame& frame, OdometryResult& result) {
  landmarks_.Update(T_odom_c_, tracked.alignment.matches, frame);
  if (IsFrameToFrame()) {
    landmarks_.Initialise(T_odom_c_, frame);
  } else {
    landmarks_.Create(T_odom_c_, frame);
  }
  result.n_moving = bodies_.CountFeatures(frame);
}

void Odometry::ChooseKeyframe(const Tracked& tracked, const TrackedFrame& frame, OdometryResult& result) {
  if (keyframes_.begins_session()) return MakeKeyframe(KeyframeReason::kFirst, result);
  if (tracked.reference != Reference::kCurrent) return MakeKeyframe(KeyframeReason::kTracked, result);
  // In localisation-only mode keyframes only adopt the local map, so known landmarks are no reason against them.
  const KeyframeDecision decision =
      keyframes_.Decide(frame, T_odom_c_, covariance_.since_keyframe(), !options_.map.localise_only);
  result.entropy_ratio = decision.entropy_ratio;
  if (decision.reason == KeyframeReason::kNone) return;
  if (frame.is_followed) return following_.RequireDetection();
  MakeKeyframe(decision.reason, result);
}

void Odometry::MakeKeyframe(KeyframeReason reason, OdometryResult& result) {
  result.keyframe = keyframes_.Make(reason, T_odom_c_, covariance_.between_keyframes(), landmarks_);
  result.keyframe->inertial = motion_.TakeInterval();
  covariance_.BeginKeyframe();
}

void Odometry::Calibrate(const Tracked& tracked, double dt_s, TrackedFrame& frame, const OdometryResult& result) {
  // The errors of followed features are those of their detection: they agree with each other, whatever these are.
  if (!frame.is_followed) calibrator_.LearnNoise(tracked.alignment);
  if (frame.rolling && tracked.is_first_motion) {
    // It shows by how much the landmarks created before it were displaced.
    frame.MoveToStamp(result.T_prev_c.Log() / dt_s);
    landmarks_.Initialise(T_odom_c_, frame);
  }
  if (result.state == TrackingState::kRecovered) {
    calibrator_.InterruptTiming();
  } else if (calibrator_.LearnTiming(T_odom_c_, result.T_prev_c, dt_s, frame)) {
    keyframes_.ForgetMeasurements();
    CreateLandmarksAgain(frame);
  }
  if (calibrator_.LearnDisparities(T_odom_c_, frame)) {
    keyframes_.ForgetMeasurements();
    CreateLandmarksAgain(frame);
  }
  if (calibrator_.LearnDelay(result.T_prev_c, dt_s, frame)) CreateLandmarksAgain(frame);
}

void Odometry::CreateLandmarksAgain(TrackedFrame& frame) {
  bodies_.Forget();
  landmarks_.Initialise(T_odom_c_, frame);
}

/// The landmarks stay, and a frame that shows others adds these: it is not lost.
void Odometry::Carry(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame, OdometryResult& result) {
  result.state = TrackingState::kWeak;
  result.carried = true;
  covariance_.Carry(prediction);
  Predict(prediction, dt_s, result);
  bodies_.FollowWhileLost(recovery_.Carry(), dt_s, motion_.inertial(), landmarks_, frame);
  if (CreatableLandmarks(frame.features) < options_.tracking.weak_inliers) return;
  landmarks_.Create(T_odom_c_, frame);
  recovery_.CreatedWhileCarried();
}

void Odometry::Miss(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame, OdometryResult& result) {
  result.state = TrackingState::kLost;
  const int n_lost = recovery_.Miss(T_odom_c_, dt_s, prediction.by_robot, landmarks_);
  covariance_.Miss(prediction);
  Predict(prediction, dt_s, result);
  bodies_.FollowWhileLost(n_lost, dt_s, motion_.inertial(), landmarks_, frame);
  // The next frame may match this one even if neither matches the previous landmarks.
  landmarks_.Initialise(T_odom_c_, frame);
}

/// Moves the camera to the predicted pose.
void Odometry::Predict(const MotionPrediction& prediction, double dt_s, OdometryResult& result) {
  result.T_prev_c = prediction.T_prev_c;
  result.motion_covariance = prediction.covariance;
  T_odom_c_ = T_odom_c_ * prediction.T_prev_c;
  motion_.Miss(prediction.T_prev_c, dt_s);
  calibrator_.Interrupt();
}

void Odometry::Publish(const std::optional<Tracked>& tracked, double dt_s, OdometryResult& result) {
  covariance_.Publish(calibrator_.disparities().LengthSigma(), keyframes_.SinceKeyframe(T_odom_c_), result);
  if (!tracked) return;
  // The robot's own odometry is compared only with motions that are measured without doubt; the inertial sensor observes
  // doubtful ones, too, because it is what decides between two.
  const bool is_sure = result.state == TrackingState::kTracking && !result.jumped;
  motion_.robot().Observe(result.T_prev_c, result.motion_covariance, dt_s, is_sure);
  if (tracked->confirmed) {
    motion_.ReplaceInertial(tracked->confirmed->inertial);
  } else {
    motion_.ObserveInertial(tracked->seen.T_odom_c, tracked->seen.covariance, !tracked->alignment.weak,
                            result.jumped);
    motion_.DriftInertial(result.motion_covariance);
  }
  if (!tracked->rival) return;
  // Two motions were equally likely: the covariance covers both.
  result.covariance += SquareOf(T_odom_c_.Inverse() * tracked->rival->T_odom_c);
  result.motion_covariance += SquareOf(result.T_prev_c.Inverse() * tracked->rival->T_prev_c);
}

/// Takes the frame's measurements for the next keyframe, and fills in the content of the frame's own.
OdometryResult Odometry::Completed(TrackedFrame frame, OdometryResult result) {
  const bool found = result.state != TrackingState::kInitialising && result.state != TrackingState::kLost;
  if (found && !result.carried) keyframes_.Add(T_odom_c_, frame);
  if (result.keyframe) {
    result.keyframe->content = keyframes_.TakeContent(result.keyframe->id, frame, landmarks_);
    result.keyframe->withdrawn_points = bodies_.TakeWithdrawnPoints();
    result.keyframe->withdrawn_lines = bodies_.TakeWithdrawnLines();
  }
  if (!frame.is_followed) {
    calibrator_.ObserveCorners(frame);
    tracker_.SetPose(T_odom_c_);
  }
  following_.Observe(result.state == TrackingState::kTracking && !result.jumped);
  result.is_followed = frame.is_followed;
  motion_.ExpectNothing();
  result.T_odom_c = T_odom_c_;
  result.up = motion_.inertial().Up();
  result.n_bodies = static_cast<int>(bodies_.n_met());
  result.bodies = bodies_.Poses();
  result.features = std::move(frame.features);
  result.point_tracks = std::move(frame.point_tracks);
  result.line_tracks = std::move(frame.line_tracks);
  return result;
}

// Adoption of the map's landmarks, and relocalisation.

bool Odometry::Adopt(const Map& map, const KeyframeName& keyframe) {
  auto local_map = keyframes_.LocalMapAround(map, keyframe, options_.map.local_keyframes);
  if (!local_map) return false;
  bodies_.LeaveOut(*local_map);
  const auto T_w_odom =
      PlacementInMap(landmarks_, *local_map, T_odom_c_, camera_, options_.motion, options_.tracking.weak_inliers);
  if (T_w_odom) local_map->T_w_odom = *T_w_odom;
  T_w_odom_ = local_map->T_w_odom;
  is_in_map_ = true;
  covariance_.Learn(map, keyframe.session);
  recovery_.Adopt(*local_map, landmarks_);
  return true;
}

bool Odometry::AdoptAround(const Map& map) {
  std::map<KeyframeId, int> counts;
  const auto count = [&](const auto& landmarks, const auto& find) {
    for (const auto& landmark : landmarks) {
      if (landmark.map_id < 0 || landmark.unseen_frames > 0 || find(landmark.map_id) == nullptr) continue;
      for (const Observation& observation : find(landmark.map_id)->observations) ++counts[observation.keyframe_id()];
    }
  };
  count(landmarks_.points.landmarks(), [&map](LandmarkId id) { return map.FindPoint(id); });
  count(landmarks_.lines.landmarks(), [&map](LandmarkId id) { return map.FindLine(id); });
  const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto best = std::max_element(counts.begin(), counts.end(), fewer);
  if (recovery_.is_lost() || best == counts.end()) return false;
  auto local_map = LocalMapAt(map, best->first, T_w_odom_, options_.map.local_keyframes);
  if (!local_map) return false;
  bodies_.LeaveOut(*local_map);
  landmarks_.Adopt(*local_map);
  return true;
}

bool Odometry::Relocalise(const Map& map, KeyframeId map_keyframe_id, const SE3& T_w_odom) {
  auto local_map = LocalMapAt(map, map_keyframe_id, T_w_odom, options_.map.local_keyframes);
  if (!local_map) return false;
  bodies_.LeaveOut(*local_map);
  following_.RequireDetection();
  recovery_.Relocalise(*local_map, landmarks_);
  return true;
}

}  // namespace plslam::vo
