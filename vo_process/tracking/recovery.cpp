// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/recovery.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace plslam::vo {
namespace {

// Share of the inliers before the loss that shows the same place: by descriptors alone a few agree anywhere, and in
// repeated structure more. The second value applies later, when the camera may be anywhere.
constexpr double kRecoveredShare = 0.1;
constexpr double kRecoveredShareLater = 0.4;
constexpr int kSoonFrames = 5;

}  // namespace

std::optional<Tracked> Recovery::Find(const Query& query, LocalLandmarks& landmarks) {
  // A lost camera needs strong evidence: first for the place where it was lost, then for the relocalised one, then for
  // the previous frame.
  std::optional<Tracked> tracked;
  if (is_lost()) tracked = FindInPreviousLocalMap(query, landmarks);
  if (!tracked && relocalised_) tracked = FindRelocalised(query, landmarks);
  if (!tracked) tracked = FindCurrent(query, landmarks);
  if (!tracked) return std::nullopt;
  tracked->is_first_motion = !query.knows_motion;
  state_ = Tracking();
  return tracked;
}

std::optional<Tracked> Recovery::FindInPreviousLocalMap(const Query& query, LocalLandmarks& landmarks) {
  // Soon after the loss the camera is near its predicted pose; later it may be anywhere, as likely back at the loss,
  // unless the robot's odometry covers the whole interval.
  Lost& lost = std::get<Lost>(state_);
  const bool soon = lost.n_frames <= kSoonFrames;
  auto found = Align(query, lost.landmarks, soon || lost.by_robot ? query.T_odom_prev : lost.T_odom_c);
  const double share = soon ? kRecoveredShare : kRecoveredShareLater;
  if (!found || found->weak || found->matches.Weight() < share * tracked_weight_) return std::nullopt;
  lost.landmarks.ContinueNumbering(landmarks);
  landmarks = std::move(lost.landmarks);
  relocalised_.reset();
  return Tracked{std::move(*found), Reference::kPreviousLocalMap, lost.T_odom_c, lost.elapsed_s};
}

std::optional<Tracked> Recovery::FindRelocalised(const Query& query, LocalLandmarks& landmarks) {
  Relocalised place = *std::exchange(relocalised_, std::nullopt);
  auto found = Align(query, place.landmarks, query.T_odom_prev);
  if (!found || found->weak) return std::nullopt;
  const bool was_lost = !KeepOdometry(query, landmarks, *found, place);
  place.landmarks.ContinueNumbering(landmarks);
  landmarks = std::move(place.landmarks);
  Tracked tracked{std::move(*found), was_lost ? Reference::kRelocalised : Reference::kLocalised};
  tracked.T_w_odom = place.T_w_odom;
  return tracked;
}

/// If the camera was not lost, keeps odometry's pose, and moves the map's landmarks and T_w_odom to fit it.
bool Recovery::KeepOdometry(const Query& query, const LocalLandmarks& landmarks, Alignment& found,
                            Relocalised& place) const {
  if (is_lost()) return false;
  const auto own = Align(query, landmarks, query.T_odom_prev);
  if (!own || own->weak) return false;
  const SE3 T_odom_place = own->T_odom_c * found.T_odom_c.Inverse();
  place.landmarks.Move(T_odom_place);
  place.T_w_odom = place.T_w_odom * T_odom_place.Inverse();
  found.T_odom_c = own->T_odom_c;
  found.covariance = own->covariance;
  return true;
}

std::optional<Tracked> Recovery::FindCurrent(const Query& query, const LocalLandmarks& landmarks) const {
  auto found = Align(query, landmarks, query.T_odom_prev);
  // A long gap needs strong evidence as well: a few chance inliers would become a keyframe, since no prediction
  // contradicts them.
  const bool gap = query.knows_motion && !query.prediction.is_near;
  if (!found || ((is_lost() || gap) && found->weak)) return std::nullopt;
  if (is_lost()) return Tracked{std::move(*found), Reference::kCreatedWhileLost};
  // After many dark frames the camera may see another part of a world whose parts look alike, but it is where the
  // inertial sensor carried it.
  const Carried* carried = std::get_if<Carried>(&state_);
  if (carried != nullptr && query.prediction.since_measured) {
    MotionPrediction comparable = query.prediction;
    comparable.covariance += found->covariance;
    const SE3 T_odom_predicted = query.T_odom_prev * query.prediction.T_prev_c;
    if (SquaredDeviation(comparable, T_odom_predicted, found->T_odom_c) > kExpectedChi2) return std::nullopt;
  }
  const bool is_new = carried != nullptr && carried->created_landmarks;
  return Tracked{std::move(*found), is_new ? Reference::kCreatedWhileCarried : Reference::kCurrent};
}

// Without a known velocity all searches are compared: a camera that starts at speed is mostly outside the near window,
// where only far landmarks agree, on a wrong motion.
std::optional<Alignment> Recovery::Align(const Query& query, const LocalLandmarks& landmarks,
                                         const SE3& T_odom_prev) const {
  const int expected = query.knows_motion ? tracked_weight_ : std::numeric_limits<int>::max();
  return aligner_.Align(landmarks, query.frame, T_odom_prev, query.prediction, expected);
}

void Recovery::Expect(int inlier_score) {
  // One mediocre frame lowers the expectation for the next only a little.
  tracked_weight_ = std::max(inlier_score, 4 * tracked_weight_ / 5);
}

int Recovery::Carry() {
  if (!std::holds_alternative<Carried>(state_)) state_ = Carried();
  return ++std::get<Carried>(state_).n_frames;
}

void Recovery::CreatedWhileCarried() { std::get<Carried>(state_).created_landmarks = true; }

int Recovery::Miss(const SE3& T_odom_prev, double dt_s, bool by_robot, const LocalLandmarks& landmarks) {
  if (!is_lost()) state_ = Lost{landmarks, T_odom_prev};
  Lost& lost = std::get<Lost>(state_);
  lost.elapsed_s += dt_s;
  lost.by_robot = lost.by_robot && by_robot;
  return ++lost.n_frames;
}

void Recovery::Adopt(const TrackerLocalMap& local_map, LocalLandmarks& landmarks) {
  Lost* lost = std::get_if<Lost>(&state_);
  if (lost == nullptr) return landmarks.Adopt(local_map);
  // Both lists draw ids from one sequence.
  lost->landmarks.ContinueNumbering(landmarks);
  lost->landmarks.Adopt(local_map);
  landmarks.ContinueNumbering(lost->landmarks);
}

void Recovery::Relocalise(const TrackerLocalMap& local_map, LocalLandmarks& landmarks) {
  relocalised_ = Relocalised{LocalLandmarks(camera_, options_), local_map.T_w_odom};
  LocalLandmarks& there = relocalised_->landmarks;
  there.ContinueNumbering(landmarks);
  there.Adopt(local_map);
  there.CountAsSeen();
  landmarks.ContinueNumbering(there);
}

}  // namespace plslam::vo
