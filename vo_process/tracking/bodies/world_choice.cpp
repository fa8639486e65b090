// SPDX-License-Identifier: BSD-3-Clause
// Which of two motions is the world's, by the inertial sensor, by history, and by spread.
#include <algorithm>
#include <cmath>
#include <utility>

#include "vo_process/tracking/bodies/motion_evidence.h"
#include "vo_process/tracking/bodies/moving_bodies.h"
#include "vo_process/tracking/landmarks/landmark_list.h"
#include "vo_process/tracking/landmarks/match_lists.h"

namespace plslam::vo {
namespace {

// Least cells of the image with features that agree on an expected motion.
constexpr int kMinCells = 4;
constexpr double kMoreSpread = 2.25;
// Ratio of spread that confirms a choice based on spread alone.
constexpr double kClearlyMoreSpread = 3.0;
// Twice the logarithm of the ratio of likelihoods above which the inertial sensor decides between two motions, and the
// contribution of one frame to it at most.
constexpr double kDecisive = 30.0;
constexpr double kMostOfOneFrame = 15.0;
// Squared innovation (6 degrees of freedom) up to which the sensor confirms a motion.
constexpr double kConfirmed = 30.0;
// Ratio of squared innovations at which a motion clearly fits worse.
constexpr double kClearlyWorse = 2.0;

}  // namespace

// Whether the first of two motions is the world's.
bool MovingBodies::IsWorld(const Alignment& found, const FrameMatches& own, const Alignment& second,
                           const SE3& T_odom_prev, const MotionPrediction& prediction,
                           const InertialMotionModel& inertial, const TrackedFrame& frame, bool& guessed) const {
  const auto first = inertial.AgreementWith(found.T_odom_c, found.covariance);
  const auto other = inertial.AgreementWith(second.T_odom_c, second.covariance);
  if (first && other && std::min(first->innovation, other->innovation) < kConfirmed &&
      std::abs(first->surprise - other->surprise) > kMostOfOneFrame) {
    return first->surprise < other->surprise;
  }
  const Spread first_spread = SpreadOf(own, frame, camera_);
  const Spread second_spread = SpreadOf(second.matches, frame, camera_);
  const auto continues = [&](const Alignment& alignment) {
    return prediction.is_reliable && IsExpected(alignment.T_odom_c, T_odom_prev, prediction);
  };
  const bool first_continues = continues(found);
  const bool second_continues = continues(second) && second_spread.cells >= kMinCells;
  if (first_continues != second_continues) return first_continues;
  guessed = !first_continues;
  const double more = guessed ? 1.0 : kMoreSpread;
  return second_spread.Score() <= more * first_spread.Score();
}

// A body's frame was the odometry frame when the choice was made.
std::optional<RivalMotion> MovingBodies::FindRival(const FrameMatches& of_world, const TrackedFrame& frame) {
  std::optional<RivalMotion> rival;
  for (size_t k = 0; k < kMaxBodies; ++k) {
    Body& body = bodies_[k];
    if (!body.IsThere() || body.doubtful_frames == 0) continue;
    rival = RivalMotion{body.T_b_c, T_b_prev_[k].Inverse() * body.T_b_c};
    if (body.unseen_frames > 0) continue;
    const int of_body = SpreadOf(matches_[k], frame, camera_).Score();
    if (SpreadOf(of_world, frame, camera_).Score() > kClearlyMoreSpread * of_body) --body.doubtful_frames;
  }
  return rival;
}

std::optional<size_t> MovingBodies::CompareWithSensor(const InertialMotionModel& inertial, const Alignment& found) {
  if (!inertial.has_sensor() || !AnyIsThere()) return std::nullopt;
  const auto of_world = inertial.AgreementWith(found.T_odom_c, found.covariance);
  std::optional<size_t> best;
  for (size_t k = 0; k < kMaxBodies; ++k) {
    Body& body = bodies_[k];
    if (!body.IsThere() || body.unseen_frames > 0) continue;
    const auto& of_body = agreements_[k];
    if (!of_body || found.weak) continue;
    double difference = 0.0;
    if (of_world) {
      difference = of_world->surprise - of_body->surprise;
    } else {
      // A sensor that contradicts the world's poses is compared no longer, unless it has confirmed the body's for as long
      // as it takes to trust it. Errors of the sensor itself contradict both, and an inaccurate pose hides them: the
      // poses count as equally accurate, and the world's has to fit clearly worse.
      const auto equal_world = inertial.ContradictedAgreementWith(found.T_odom_c, found.covariance + covariances_[k]);
      if (!equal_world || !equal_agreements_[k] || !body.as_world.IsTrusted()) continue;
      difference = equal_world->innovation / kClearlyWorse - equal_agreements_[k]->innovation;
    }
    body.evidence = std::max(-kDecisive, body.evidence + std::clamp(difference, -kMostOfOneFrame, kMostOfOneFrame));
    if (body.evidence <= -kDecisive) body.doubtful_frames = 0;
    const bool is_confirmed =
        body.evidence >= kDecisive && of_body->innovation < kConfirmed && matches_[k].Weight() >= kMinWeight;
    if (is_confirmed && (!best || body.evidence > bodies_[*best].evidence)) best = k;
  }
  return best;
}

/// The landmarks of the world become a body's, and the body's become the world's.
ConfirmedWorld MovingBodies::Exchange(size_t k, const SE3& T_odom_prev, double dt_s,
                                      const InertialMotionModel& inertial, LocalLandmarks& world, Alignment& found) {
  Body& body = bodies_[k];
  for (const PointLandmark& landmark : body.landmarks.points.landmarks()) {
    owned_points_.Remove(landmark.id, landmark.map_id);
  }
  for (const LineLandmark& landmark : body.landmarks.lines.landmarks()) {
    owned_lines_.Remove(landmark.id, landmark.map_id);
  }
  body.landmarks.ContinueNumbering(world);
  std::swap(body.landmarks, world);
  Own(body.landmarks);
  // The body's model of the sensor has observed this frame.
  ConfirmedWorld confirmed{body.motion, body.as_world};
  Alignment of_world;
  of_world.T_odom_c = body.T_b_c;
  of_world.covariance = covariances_[k];
  of_world.matches = std::move(matches_[k]);
  std::swap(of_world, found);
  body.id = next_body_id_++;
  body.T_b_c = of_world.T_odom_c;
  body.motion.Forget();
  body.motion.Observe(T_odom_prev.Inverse() * body.T_b_c, dt_s, of_world.covariance);
  body.as_world = inertial;
  body.as_world.Observe(body.T_b_c, of_world.covariance, true, false);
  if (body.found_frames >= kMetFrames) --n_met_;
  body.found_frames = 1;
  body.standing_frames = body.doubtful_frames = 0;
  body.evidence = -kDecisive;
  matches_[k] = std::move(of_world.matches);
  covariances_[k] = of_world.covariance;
  T_b_prev_[k] = T_odom_prev;
  body.middle_b = MiddleOf(body.landmarks, matches_[k]);
  return confirmed;
}

}  // namespace plslam::vo
