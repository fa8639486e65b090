// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/odometry.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "core/motion/robust.h"
#include "vo_process/stereo/row_field.h"
#include "vo_process/tracking/calibration/noise_scale.h"
#include "vo_process/tracking/landmarks/frame_figures.h"

namespace plslam::vo {
namespace {

constexpr double kMinInterval_s = 1e-3;
// Share of the inliers before the loss that shows the same place: by descriptors alone a few agree anywhere, and in
// repeated structure more. The second value applies later, when the camera may be anywhere.
constexpr double kRecoveredShare = 0.1;
constexpr double kRecoveredShareLater = 0.4;
constexpr int kSoonFrames = 5;
// Longest interval between two observations of the same landmarks from which a velocity is computed.
constexpr double kLongestStep_s = 0.5;

std::vector<double> PointDisparities(const StereoFeatures& features) {
  std::vector<double> disparities;
  disparities.reserve(features.points.size());
  for (const StereoPoint& point : features.points) disparities.push_back(point.disparity_px);
  return disparities;
}

// Features of a frame for a keyframe, except those on bodies, which must not enter a map.
KeyframeContent ContentOfWorld(const TrackedFrame& frame) {
  KeyframeContent content;
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    if (!frame.point_tracks[i].IsOfWorld()) continue;
    content.features.points.push_back(frame.features.points[i]);
    content.point_tracks.push_back(frame.point_tracks[i]);
  }
  for (size_t i = 0; i < frame.features.lines.size(); ++i) {
    if (!frame.line_tracks[i].IsOfWorld()) continue;
    content.features.lines.push_back(frame.features.lines[i]);
    content.line_tracks.push_back(frame.line_tracks[i]);
  }
  return content;
}

Matrix6d SquareOf(const SE3& difference) {
  const Vector6d x = difference.Log();
  return x * x.transpose();
}

}  // namespace

Matrix6d UnknownMotion() {
  Vector6d variances;
  variances << 100.0, 100.0, 100.0, 1.0, 1.0, 1.0;
  return variances.asDiagonal();
}

Odometry::Odometry(const StereoCamera& camera, const VoOptions& options, const RollingShutter& shutter,
                   const std::optional<MountedImu>& imu)
    : camera_(camera),
      options_(options),
      aligner_(camera, options),
      motion_model_(options.tracking),
      inertial_(imu),
      noise_scale_(options.landmarks.max_point_scale),
      keyframe_policy_(options.keyframes),
      calibration_(camera, options.disparity_calibration),
      row_calibration_(camera, options.row_calibration),
      corner_budget_(options.features.orb.max_points),
      sync_check_(camera),
      timing_check_(camera, shutter),
      shutter_(shutter),
      states_readout_(!shutter.is_global()),
      landmarks_(camera, options),
      bodies_(camera, options),
      keyframe_measurements_(camera) {}

// Seconds since the last frame. Unsigned, because time stamps at both ends of their range would overflow.
double Odometry::SecondsSince(int64_t t_ns) const {
  const auto dt_ns = static_cast<int64_t>(static_cast<uint64_t>(t_ns) - static_cast<uint64_t>(last_t_ns_));
  return std::max(1e-9 * static_cast<double>(dt_ns), kMinInterval_s);
}

MotionPrediction Odometry::Predict(double dt_s) const {
  return inertial_.Predict(robot_model_.Predict(motion_model_.Predict(dt_s), dt_s));
}

void Odometry::Expect(int64_t t_ns) {
  skew_ = PairSkew();
  if (!initialised_ || sync_check_.late_s() == 0.0) return;
  const double dt_s = SecondsSince(t_ns);
  skew_ = sync_check_.SkewOf(Predict(dt_s).T_prev_c, dt_s);
}

bool Odometry::LearnRows(const StereoFeatures& features) {
  const bool changed = row_calibration_.Observe(features, skew_);
  if (changed) calibration_ = DisparityCalibration(camera_, options_.disparity_calibration);
  return changed;
}

OdometryResult Odometry::Track(int64_t t_ns, StereoFeatures features) {
  const double dt_s = SecondsSince(t_ns);
  last_t_ns_ = t_ns;
  TrackedFrame frame = Prepare(std::move(features));
  OdometryResult result;
  if (initialised_) {
    Follow(dt_s, frame, result);
  } else {
    Initialise(frame, result);
  }
  result.T_odom_c = T_odom_c_;
  FillKeyframe(frame, result);
  result.n_bodies = static_cast<int>(bodies_.n_met());
  result.bodies = bodies_.Poses();
  corner_budget_.Observe(frame);
  robot_model_.Expect(std::nullopt);
  inertial_.Expect({}, 0, 0);
  result.features = std::move(frame.features);
  result.point_tracks = std::move(frame.point_tracks);
  result.line_tracks = std::move(frame.line_tracks);
  return result;
}

/// Applies what was learned about the measurements: their noise, and the offset of the disparities.
TrackedFrame Odometry::Prepare(StereoFeatures features) const {
  AddLineModelError(options_.landmarks.line_model_sigma_px, features);
  std::vector<double> raw_disparities_px = PointDisparities(features);
  noise_scale_.Apply(features);
  calibration_.Correct(features);
  TrackedFrame frame(std::move(features));
  frame.raw_disparities_px = std::move(raw_disparities_px);
  frame.point_sigma_scale = noise_scale_.scale();
  return frame;
}

/// Predicts the motion, finds the frame among the landmarks, and learns from it.
void Odometry::Follow(double dt_s, TrackedFrame& frame, OdometryResult& result) {
  const MotionPrediction prediction = Predict(dt_s);
  rolling_.reset();
  if (!shutter_.is_global()) {
    rolling_.emplace(shutter_, frame.features);
    MoveToStamp(prediction.T_prev_c.Log() / dt_s, frame);
  }
  auto tracked = Find(frame, prediction.ForSearch());
  const bool first_motion = rolling_ && !motion_model_.knows_motion();
  if (rolling_ && tracked && !first_motion) EstimateVelocity(dt_s, *tracked, frame);
  if (!tracked) {
    has_last_velocity_ = false;
    const bool carries = !previous_local_map_ && inertial_.CanCarry();
    carries ? Carry(prediction, dt_s, frame, result) : Miss(prediction, dt_s, frame, result);
    calibration_.Interrupt();
    timing_check_.Interrupt();
    sync_check_.Interrupt();
    return PublishCovariance(result);
  }
  SeparateBodies(*tracked, prediction.ForSearch(), dt_s, frame);
  Accept(*tracked, dt_s, frame, result);
  if (first_motion) UseFirstVelocity(result.T_prev_c, dt_s, frame);
  CheckTiming(frame, result, dt_s);
  CalibrateDisparities(frame);
  CheckSync(frame, result.T_prev_c, dt_s);
  PublishCovariance(result);
  LearnAboutRobot(dt_s, result);
  inertial_.Observe(T_odom_c_, tracked->alignment.covariance, !tracked->alignment.weak && !tracked->rival,
                    result.jumped);
  if (!tracked->rival) return;
  // Two motions were equally likely: the covariance covers both.
  result.covariance += SquareOf(T_odom_c_.Inverse() * tracked->rival->T_odom_c);
  result.motion_covariance += SquareOf(result.T_prev_c.Inverse() * tracked->rival->T_prev_c);
}

/// Takes the frame's measurements for the next keyframe, and fills in the content of the frame's own.
void Odometry::FillKeyframe(const TrackedFrame& frame, OdometryResult& result) {
  const bool found = result.state != TrackingState::kInitialising && result.state != TrackingState::kLost;
  const bool means = options_.keyframes.measurements == "mean";
  if (found && !result.carried && means) keyframe_measurements_.Add(T_odom_c_, frame);
  if (!result.keyframe) return;
  KeyframeContent& content = result.keyframe->content;
  content = ContentOfWorld(frame);
  result.keyframe->withdrawn_points = bodies_.TakeWithdrawnPoints();
  result.keyframe->withdrawn_lines = bodies_.TakeWithdrawnLines();
  if (means) content = keyframe_measurements_.Take(landmarks_, std::move(content));
  keyframe_log_.Add(result.keyframe->id, TrackedLandmarkIds(content.point_tracks),
                    TrackedLandmarkIds(content.line_tracks));
}

void Odometry::Initialise(TrackedFrame& frame, OdometryResult& result) {
  result.state = TrackingState::kInitialising;
  if (CreatableLandmarks(frame.features) < options_.tracking.weak_inliers) return;
  landmarks_.Create(T_odom_c_, frame);
  initialised_ = true;
  result.state = TrackingState::kTracking;
  MakeKeyframe(KeyframeReason::kFirst, result);
}

std::optional<Odometry::Tracked> Odometry::Find(const TrackedFrame& frame, const MotionPrediction& prediction) {
  // A lost camera needs strong evidence: first for the place where it was lost, then for the relocalised one, then for
  // the previous frame.
  if (previous_local_map_) {
    if (auto tracked = FindInPreviousLocalMap(frame, prediction)) return tracked;
  }
  if (relocalised_) {
    if (auto tracked = FindRelocalised(frame, prediction)) return tracked;
  }
  auto found = aligner_.Align(landmarks_, frame, T_odom_c_, prediction, ExpectedWeight());
  // The same after a long gap, where a few chance inliers would become a keyframe, since no prediction contradicts
  // them.
  const bool gap = motion_model_.knows_motion() && !prediction.is_near;
  if (!found || ((previous_local_map_ || gap) && found->weak)) return std::nullopt;
  const bool was_lost = previous_local_map_.has_value();
  previous_local_map_.reset();
  const Reference not_lost = created_while_carried_ ? Reference::kCreatedWhileCarried : Reference::kCurrent;
  return Tracked{std::move(*found), was_lost ? Reference::kCreatedWhileLost : not_lost};
}

// Without a known velocity all searches are compared: a camera that starts at speed is mostly outside the near window,
// where only far landmarks agree, on a wrong motion.
int Odometry::ExpectedWeight() const {
  return motion_model_.knows_motion() ? tracked_weight_ : std::numeric_limits<int>::max();
}

std::optional<Odometry::Tracked> Odometry::FindInPreviousLocalMap(const TrackedFrame& frame,
                                                                  const MotionPrediction& prediction) {
  // Soon after the loss the camera is near its predicted pose; later it may be anywhere, as likely back at the loss,
  // unless the robot's odometry covers the whole interval.
  const bool soon = previous_local_map_->n_lost <= kSoonFrames;
  const SE3& T_odom_last = soon || previous_local_map_->by_robot ? T_odom_c_ : previous_local_map_->T_odom_c;
  auto found = aligner_.Align(previous_local_map_->landmarks, frame, T_odom_last, prediction, ExpectedWeight());
  const double share = soon ? kRecoveredShare : kRecoveredShareLater;
  if (!found || found->weak || found->matches.Weight() < share * tracked_weight_) return std::nullopt;
  Tracked tracked{std::move(*found), Reference::kPreviousLocalMap, previous_local_map_->T_odom_c,
                  previous_local_map_->elapsed_s};
  previous_local_map_->landmarks.ContinueNumbering(landmarks_);
  landmarks_ = std::move(previous_local_map_->landmarks);
  previous_local_map_.reset();
  relocalised_.reset();
  return tracked;
}

void Odometry::SeparateBodies(Tracked& tracked, const MotionPrediction& prediction, double dt_s,
                              TrackedFrame& frame) {
  if (tracked.reference != Reference::kCurrent && tracked.reference != Reference::kLocalised &&
      tracked.reference != Reference::kCreatedWhileCarried) {
    return bodies_.SeparateKnown(dt_s, landmarks_, frame, tracked.alignment);
  }
  tracked.rival = bodies_.Separate(T_odom_c_, prediction, dt_s, calibration_, landmarks_, frame, tracked.alignment);
}

void Odometry::Accept(const Tracked& tracked, double dt_s, TrackedFrame& frame, OdometryResult& result) {
  const Alignment& alignment = tracked.alignment;
  result.state = TrackingState::kTracking;
  if (alignment.weak || tracked.rival || sync_check_.is_far_off()) result.state = TrackingState::kWeak;
  n_carried_ = 0;
  created_while_carried_ = false;
  if (tracked.reference != Reference::kCurrent && tracked.reference != Reference::kCreatedWhileCarried) {
    if (tracked.reference != Reference::kLocalised) result.state = TrackingState::kRecovered;
    // Recovered where it was lost, it is anchored in the map as it was before.
    if (tracked.reference != Reference::kPreviousLocalMap)
      is_unanchored_ = tracked.reference == Reference::kCreatedWhileLost;
  }
  result.T_prev_c = T_odom_c_.Inverse() * alignment.T_odom_c;
  result.n_tracked_points = static_cast<int>(alignment.matches.points.size());
  result.n_tracked_lines = static_cast<int>(alignment.matches.lines.size());
  // One mediocre frame lowers the expectation for the next only a little.
  tracked_weight_ = std::max(alignment.matches.Weight(), 4 * tracked_weight_ / 5);
  const Matrix6d covariance_before = alignment_covariance_;
  PropagateCovariance(tracked, result);
  noise_scale_.Observe(alignment);

  landmarks_.Update(alignment.T_odom_c, alignment.matches, frame);
  if (options_.tracking.reference == "previous_frame") {
    landmarks_.Initialise(alignment.T_odom_c, frame);
  } else {
    landmarks_.Create(alignment.T_odom_c, frame);
  }
  T_odom_c_ = alignment.T_odom_c;
  result.relocalised = tracked.reference == Reference::kRelocalised;
  result.jumped = tracked.reference == Reference::kPreviousLocalMap || tracked.reference == Reference::kRelocalised;
  result.n_moving = bodies_.CountFeatures(frame);
  LearnMotion(tracked, dt_s, covariance_before, result);
  ChooseKeyframe(tracked, frame, result);
}

// A jump is not a motion: the motion while lost gives the velocity if that was short; otherwise the velocity is
// unknown. A second image at the same time gives no velocity.
void Odometry::LearnMotion(const Tracked& tracked, double dt_s, const Matrix6d& covariance_before,
                           const OdometryResult& result) {
  if (!result.jumped) {
    if (dt_s > kMinInterval_s) motion_model_.Observe(result.T_prev_c, dt_s, result.motion_covariance);
    return;
  }
  const double unseen_s = tracked.before_s + dt_s;
  if (tracked.reference != Reference::kPreviousLocalMap || unseen_s > kLongestStep_s) return motion_model_.Forget();
  const SE3 T_before_c = tracked.T_odom_before.Inverse() * tracked.alignment.T_odom_c;
  motion_model_.Observe(T_before_c, unseen_s,
                        ComposeCovariance(covariance_before, T_before_c, tracked.alignment.covariance));
}

// Compares only motions measured without the robot's prediction and without doubt.
void Odometry::LearnAboutRobot(double dt_s, const OdometryResult& result) {
  const bool is_sure = result.state == TrackingState::kTracking && !result.jumped;
  robot_model_.Observe(result.T_prev_c, result.motion_covariance, dt_s, is_sure);
}

void Odometry::PropagateCovariance(const Tracked& tracked, OdometryResult& result) {
  const Matrix6d& alignment = tracked.alignment.covariance;
  Matrix6d chained = ComposeCovariance(covariance_kf_c_, result.T_prev_c, alignment);
  if (tracked.reference == Reference::kRelocalised) chained += UnknownMotion();
  const bool frame_to_frame = options_.tracking.reference == "previous_frame";
  // Frame to frame, or among landmarks created in the previous frame, landmarks are exact relative to that frame.
  const bool exact_before = frame_to_frame || tracked.reference == Reference::kCreatedWhileLost ||
                            tracked.reference == Reference::kCreatedWhileCarried ||
                            tracked.reference == Reference::kRelocalised;
  // Otherwise both ends were measured against the same landmarks, and the motion contains both errors.
  result.motion_covariance =
      exact_before ? alignment : ComposeCovariance(alignment_covariance_, result.T_prev_c, alignment);
  if (tracked.reference == Reference::kPreviousLocalMap || tracked.reference == Reference::kRelocalised) {
    result.motion_covariance = chained;
  }
  covariance_kf_c_ = exact_before ? chained : alignment;
  covariance_between_keyframes_ =
      exact_before
          ? chained
          : ComposeCovariance(alignment_covariance_kf_, T_odom_kf_.Inverse() * tracked.alignment.T_odom_c, alignment);
  alignment_covariance_ = alignment;
}

// The tracker uses its own covariances; only published ones include errors common to frames. After a jump, which always
// makes a keyframe, the relative pose to the previous keyframe has that keyframe's covariance, whatever was predicted
// meanwhile.
void Odometry::PublishCovariance(OdometryResult& result) {
  const bool measured = result.state != TrackingState::kLost && !result.jumped && !result.carried;
  result.motion_covariance = uncertainty_.Of(result.T_prev_c, result.motion_covariance, measured) +
                             MotionUncertainty::OfLengths(result.T_prev_c, calibration_.LengthSigma());
  const SE3 T_prevkf_c = result.keyframe ? result.keyframe->T_prevkf_kf : T_odom_kf_.Inverse() * T_odom_c_;
  published_kf_c_ = result.jumped && result.keyframe
                        ? uncertainty_.Of(T_prevkf_c, result.keyframe->covariance, false)
                        : ComposeCovariance(published_kf_c_, result.T_prev_c, result.motion_covariance);
  result.covariance = ComposeCovariance(covariance_odom_kf_, T_prevkf_c, published_kf_c_);
  if (!result.keyframe) return;
  covariance_odom_kf_ = result.covariance;
  published_kf_c_.setZero();
}

/// The landmarks stay, and a frame that shows others adds these: it is not lost.
void Odometry::Carry(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame, OdometryResult& result) {
  result.state = TrackingState::kWeak;
  result.carried = true;
  result.T_prev_c = prediction.T_prev_c;
  result.motion_covariance = prediction.covariance;
  covariance_kf_c_ = ComposeCovariance(covariance_kf_c_, prediction.T_prev_c, prediction.covariance);
  alignment_covariance_ = ComposeCovariance(alignment_covariance_, prediction.T_prev_c, prediction.covariance);
  T_odom_c_ = T_odom_c_ * prediction.T_prev_c;
  motion_model_.Slow(dt_s);
  robot_model_.Miss(dt_s);
  inertial_.Miss();
  bodies_.FollowWhileLost(++n_carried_, dt_s, landmarks_, frame);
  if (CreatableLandmarks(frame.features) < options_.tracking.weak_inliers) return;
  landmarks_.Create(T_odom_c_, frame);
  created_while_carried_ = true;
}

void Odometry::Miss(const MotionPrediction& prediction, double dt_s, TrackedFrame& frame, OdometryResult& result) {
  result.state = TrackingState::kLost;
  if (!previous_local_map_) previous_local_map_ = PreviousLocalMap{landmarks_, T_odom_c_};
  ++previous_local_map_->n_lost;
  previous_local_map_->elapsed_s += dt_s;
  result.T_prev_c = prediction.T_prev_c;
  result.motion_covariance = prediction.covariance;
  covariance_kf_c_ = ComposeCovariance(covariance_kf_c_, prediction.T_prev_c, prediction.covariance);
  T_odom_c_ = T_odom_c_ * prediction.T_prev_c;
  previous_local_map_->by_robot = previous_local_map_->by_robot && prediction.by_robot;
  motion_model_.Slow(dt_s);
  robot_model_.Miss(dt_s);
  inertial_.Miss();
  bodies_.FollowWhileLost(previous_local_map_->n_lost, dt_s, landmarks_, frame);
  // The next frame may match this one even if neither matches the previous landmarks.
  landmarks_.Initialise(T_odom_c_, frame);
}

int Odometry::TrackedFromKeyframe(const TrackedFrame& frame) const {
  const auto known_below = [](int64_t limit) {
    return [limit](const FeatureTrack& track) {
      return track.landmark_id >= 0 && track.landmark_id < limit && track.IsOfWorld();
    };
  };
  const auto points =
      std::count_if(frame.point_tracks.begin(), frame.point_tracks.end(), known_below(keyframe_point_id_));
  const auto lines =
      std::count_if(frame.line_tracks.begin(), frame.line_tracks.end(), known_below(keyframe_line_id_));
  return static_cast<int>(points + 2 * lines);
}

void Odometry::ChooseKeyframe(const Tracked& tracked, const TrackedFrame& frame, OdometryResult& result) {
  if (tracked.reference != Reference::kCurrent || begins_session_) {
    MakeKeyframe(begins_session_ ? KeyframeReason::kFirst : KeyframeReason::kTracked, result);
    return;
  }
  KeyframeCandidate candidate;
  candidate.T_kf_c = T_odom_kf_.Inverse() * T_odom_c_;
  candidate.covariance = covariance_kf_c_;
  candidate.tracked_from_keyframe = TrackedFromKeyframe(frame);
  candidate.median_depth_m = MedianDepth(frame, camera_);
  // In localisation-only mode keyframes only adopt the local map, so known landmarks are no reason against them.
  if (!options_.map.localise_only) candidate.known_share = KnownShare(frame, options_.keyframes.known_observations);
  const KeyframeDecision decision = keyframe_policy_.Decide(candidate);
  result.entropy_ratio = decision.entropy_ratio;
  if (decision.reason != KeyframeReason::kNone) MakeKeyframe(decision.reason, result);
}

void Odometry::MakeKeyframe(KeyframeReason reason, OdometryResult& result) {
  KeyframeStep step;
  step.id = next_keyframe_id_++;
  begins_session_ = false;
  step.reason = reason;
  if (step.id > 0) {
    step.previous_id = step.id - 1;
    step.T_prevkf_kf = T_odom_kf_.Inverse() * T_odom_c_;
    step.covariance = covariance_between_keyframes_;
  }
  covariance_kf_c_.setZero();
  alignment_covariance_kf_ = alignment_covariance_;
  T_odom_kf_ = T_odom_c_;
  keyframe_point_id_ = landmarks_.next_point_id;
  keyframe_line_id_ = landmarks_.next_line_id;
  keyframe_policy_.Restart();
  result.keyframe = step;
}

void Odometry::Begin(const SelfCalibration& learned) {
  if (learned.rows) row_calibration_.Begin(*learned.rows);
  if (learned.disparities) calibration_.Begin(*learned.disparities);
}

// Adoption of the map's landmarks, and relocalisation.

bool Odometry::Adopt(const Map& map, int64_t session, int64_t keyframe_id) {
  auto local_map = keyframe_log_.LocalMapAround(map, session, keyframe_id, options_.map.local_keyframes);
  if (!local_map) return false;
  bodies_.LeaveOut(*local_map);
  T_w_odom_ = local_map->T_w_odom;
  is_in_map_ = true;
  uncertainty_.Learn(map, session);
  const bool keep_own = options_.map.landmarks == "unknown";
  if (!previous_local_map_) {
    landmarks_.Adopt(*local_map, keep_own);
    return true;
  }
  // While lost, the map's landmarks belong to the previous local map; both lists draw ids from one sequence.
  LocalLandmarks& before = previous_local_map_->landmarks;
  before.ContinueNumbering(landmarks_);
  before.Adopt(*local_map, keep_own);
  landmarks_.ContinueNumbering(before);
  return true;
}

void Odometry::BeginSession() {
  next_keyframe_id_ = 0;
  keyframe_log_ = {};
  begins_session_ = true;
}

bool Odometry::AdoptAround(const Map& map) {
  std::map<int64_t, int> counts;
  const auto count = [&](const auto& landmarks, const auto& find) {
    for (const auto& landmark : landmarks) {
      if (landmark.map_id < 0 || landmark.unseen_frames > 0 || find(landmark.map_id) == nullptr) continue;
      for (const Observation& observation : find(landmark.map_id)->observations) ++counts[observation.keyframe_id];
    }
  };
  count(landmarks_.points.landmarks(), [&map](int64_t id) { return map.FindPoint(id); });
  count(landmarks_.lines.landmarks(), [&map](int64_t id) { return map.FindLine(id); });
  const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto best = std::max_element(counts.begin(), counts.end(), fewer);
  if (previous_local_map_ || best == counts.end()) return false;
  auto local_map = LocalMapAt(map, best->first, T_w_odom_, options_.map.local_keyframes);
  if (!local_map) return false;
  bodies_.LeaveOut(*local_map);
  landmarks_.Adopt(*local_map, false);
  return true;
}

bool Odometry::Relocalise(const Map& map, int64_t map_keyframe_id, const SE3& T_w_odom) {
  auto local_map = LocalMapAt(map, map_keyframe_id, T_w_odom, options_.map.local_keyframes);
  if (!local_map) return false;
  bodies_.LeaveOut(*local_map);
  relocalised_ = Relocalised{LocalLandmarks(camera_, options_), T_w_odom};
  LocalLandmarks& landmarks = relocalised_->landmarks;
  landmarks.ContinueNumbering(landmarks_);
  landmarks.Adopt(*local_map, false);
  landmarks.CountAsSeen();
  landmarks_.ContinueNumbering(landmarks);
  return true;
}

std::optional<Odometry::Tracked> Odometry::FindRelocalised(const TrackedFrame& frame,
                                                           const MotionPrediction& prediction) {
  Relocalised place = *std::exchange(relocalised_, std::nullopt);
  auto found = aligner_.Align(place.landmarks, frame, T_odom_c_, prediction, ExpectedWeight());
  if (!found || found->weak) return std::nullopt;
  const bool was_lost = !KeepOdometry(frame, prediction, *found, place);
  place.landmarks.ContinueNumbering(landmarks_);
  landmarks_ = std::move(place.landmarks);
  T_w_odom_ = place.T_w_odom;
  is_in_map_ = true;
  previous_local_map_.reset();
  return Tracked{std::move(*found), was_lost ? Reference::kRelocalised : Reference::kLocalised};
}

/// If the camera was not lost, keeps odometry's pose, and moves the map's landmarks and T_w_odom to fit it.
bool Odometry::KeepOdometry(const TrackedFrame& frame, const MotionPrediction& prediction, Alignment& found,
                            Relocalised& place) const {
  if (previous_local_map_) return false;
  const auto own = aligner_.Align(landmarks_, frame, T_odom_c_, prediction, ExpectedWeight());
  if (!own || own->weak) return false;
  const SE3 T_odom_place = own->T_odom_c * found.T_odom_c.Inverse();
  place.landmarks.Move(T_odom_place);
  place.T_w_odom = place.T_w_odom * T_odom_place.Inverse();
  found.T_odom_c = own->T_odom_c;
  found.covariance = own->covariance;
  return true;
}

}  // namespace plslam::vo
