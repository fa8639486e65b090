// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/bodies/moving_bodies.h"

#include <array>
#include <limits>
#include <utility>

#include "core/features/matching/segment_projection.h"
#include "core/motion/pose_ransac.h"
#include "core/motion/robust.h"
#include "vo_process/tracking/bodies/motion_evidence.h"
#include "vo_process/tracking/landmarks/landmark_list.h"
#include "vo_process/tracking/landmarks/match_lists.h"

namespace plslam::vo {
namespace {

// Least exclusive inliers (points + 2 x lines) of a known body to be followed.
constexpr int kMinFollowedWeight = 15;
constexpr double kMinInlierRatio = 0.5;
// Share of the features of two groups that must agree on one motion to be one body.
constexpr double kMinJoinedRatio = 0.7;
// Two bodies whose motions differ by less than this, at the smaller one, may be parts of one.
constexpr double kAlike_px = 2.0;
// A match contradicts a pose if its error is larger than this, or than this number of sigmas of its disparity.
constexpr double kContradiction_px = 3.0;
constexpr double kContradictionSigmas = 4.0;
// Largest distance of a body's feature from its last position, or from its position if the body stood.
constexpr double kSearchRadius_px = 40.0;
constexpr double kRansacInlier_px = 3.0;
constexpr uint64_t kRansacSeed = 1;
// A feature of the world is given to a body if the body has this many times as many features around it as the world.
constexpr int kSurroundedTimes = 3;
// Frames out of view after which features near a body create landmarks of the world again, and after which a body is
// forgotten.
constexpr int kGuardedFrames = 5;
constexpr int kMaxUnseenFrames = 10;
constexpr int kStandingFrames = 10;
// Least motion in the image, if the body moved with the camera, that shows whether it stands.
constexpr double kShownMotion_px = 2.0;
constexpr double kStandingMotion_px = 0.7;
// Frames in which the spread of the world must confirm a choice that is based on spread alone.
constexpr int kDoubtfulFrames = 5;

/// Returns the difference in the image between two motions of the camera since the previous frame, relative to two
/// bodies: the median over the matches of the second.
double MotionDifference_px(const SE3& T_c_prev, const SE3& T_c_prev_of_second, const SE3& T_prev_b,
                           const Body& second, const FrameMatches& matches, const StereoCamera& camera) {
  std::vector<double> differences;
  for (const LandmarkMatch& match : matches.points) {
    const Eigen::Vector3d p_prev = T_prev_b * second.landmarks.points.landmarks()[match.landmark].p_odom;
    const Eigen::Vector3d p_c = T_c_prev * p_prev;
    const Eigen::Vector3d p_c_of_second = T_c_prev_of_second * p_prev;
    if (std::min(p_c.z(), p_c_of_second.z()) < camera.MinDepth()) continue;
    differences.push_back((camera.ProjectStereo(p_c) - camera.ProjectStereo(p_c_of_second)).norm());
  }
  return differences.empty() ? std::numeric_limits<double>::infinity() : Median(differences);
}

}  // namespace

struct MovingBodies::Rest {
  Rest(const TrackedFrame& whole, const Claims& claims)
      : points(PlacesOf(claims.points, false)),
        lines(PlacesOf(claims.lines, false)),
        frame({Chosen(whole.features.points, points), Chosen(whole.features.lines, lines), {}}) {
    frame.point_sigma_scale = whole.point_sigma_scale;
  }

  FrameMatches InWhole(const FrameMatches& matches) const {
    return {Renumbered(matches.points, {}, points), Renumbered(matches.lines, {}, lines)};
  }

  /// Indices of the features in the whole frame.
  std::vector<int> points;
  std::vector<int> lines;
  TrackedFrame frame;
};

MovingBodies::MovingBodies(const StereoCamera& camera, const VoOptions& options, const std::optional<MountedImu>& imu)
    : camera_(camera),
      aligner_(camera, options),
      bodies_(kMaxBodies, Body(camera, options, imu)),
      matches_(kMaxBodies),
      T_b_prev_(kMaxBodies),
      covariances_(kMaxBodies, Matrix6d::Zero()),
      agreements_(kMaxBodies),
      equal_agreements_(kMaxBodies) {}

void MovingBodies::Forget() {
  for (Body& body : bodies_) body.id = -1;
}

bool MovingBodies::AnyIsThere() const {
  return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return body.IsThere(); });
}

Separation MovingBodies::Separate(const SE3& T_odom_prev, const MotionPrediction& prediction, double dt_s,
                                  const DisparityCalibration& calibration, const InertialMotionModel& inertial,
                                  LocalLandmarks& world, TrackedFrame& frame, Alignment& found) {
  Claims claims = Follow(dt_s, inertial, frame, found);
  Separation result;
  SE3 T_world_prev = T_odom_prev;
  if (const auto confirmed = CompareWithSensor(inertial, found)) {
    T_world_prev = T_b_prev_[*confirmed];
    result.confirmed = Exchange(*confirmed, T_odom_prev, dt_s, inertial, world, found);
  }
  // Without a prediction (as after a long gap), a second motion proves little; but in the first pair of frames the
  // motion found may be that of a body.
  const bool is_asked = !result.confirmed && (prediction.is_reliable || is_first_pair_);
  is_first_pair_ = false;
  while (is_asked && FindNew(T_odom_prev, prediction, dt_s, calibration, inertial, world, frame, claims, found)) {
  }
  if (!AnyIsThere()) return result;
  const FeaturePlaces places = AllPlaces(found.matches, frame);
  AssignToBodies(world, frame, places, found);
  // The remaining features of the world may not determine its motion: the predicted motion then takes part.
  if (!result.confirmed && !found.weak && found.matches.Weight() < kMinWeight) {
    const MotionPrior prior{(T_odom_prev * prediction.T_prev_c).Inverse(), prediction.covariance};
    if (auto held = aligner_.Estimate(world, frame, found.matches, found.T_odom_c, prior)) found = std::move(*held);
    found.weak = true;
  }
  NameFeatures(places, found.matches, frame);
  CreateLandmarksOnBodies(world, frame);
  result.rival = FindRival(found.matches, frame);
  ReleaseStandingBodies(T_world_prev, found.T_odom_c, world, frame);
  return result;
}

void MovingBodies::SeparateKnown(double dt_s, const InertialMotionModel& inertial, LocalLandmarks& world,
                                 TrackedFrame& frame, Alignment& found) {
  if (!AnyIsThere()) return;
  Follow(dt_s, inertial, frame, found);
  const FeaturePlaces places = AllPlaces(found.matches, frame);
  AssignToBodies(world, frame, places, found);
  NameFeatures(places, found.matches, frame);
  CreateLandmarksOnBodies(world, frame);
}

void MovingBodies::FollowWhileLost(int n_lost, double dt_s, const InertialMotionModel& inertial,
                                   LocalLandmarks& world, TrackedFrame& frame) {
  if (!AnyIsThere()) return;
  const auto may_be_world = [](const Body& body) { return body.IsThere() && body.doubtful_frames > 0; };
  if (n_lost > kMaxUnseenFrames || std::any_of(bodies_.begin(), bodies_.end(), may_be_world)) return Forget();
  const Alignment none;
  Follow(dt_s, inertial, frame, none);
  NameFeatures(AllPlaces(none.matches, frame), none.matches, frame);
  CreateLandmarksOnBodies(world, frame);
}

void MovingBodies::CreateLandmarksOnBodies(LocalLandmarks& world, TrackedFrame& frame) {
  for (size_t k = 0; k < kMaxBodies; ++k) {
    Body& body = bodies_[k];
    if (!body.IsThere()) continue;
    body.landmarks.Update(body.T_b_c, matches_[k], frame);
    NameMatched(matches_[k], static_cast<int>(k), frame);
    if (body.unseen_frames > 0) continue;
    body.landmarks.ContinueNumbering(world);
    body.landmarks.Create(body.T_b_c, frame, static_cast<int>(k));
    world.ContinueNumbering(body.landmarks);
  }
}

MovingBodies::Claims MovingBodies::Follow(double dt_s, const InertialMotionModel& inertial, const TrackedFrame& frame,
                                          const Alignment& of_world) {
  Claims claims{FlagsOf(of_world.matches.points, &LandmarkMatch::feature, frame.features.points.size()),
                FlagsOf(of_world.matches.lines, &LandmarkMatch::feature, frame.features.lines.size())};
  for (size_t k = 0; k < kMaxBodies; ++k) {
    matches_[k] = {};
    agreements_[k].reset();
    equal_agreements_[k].reset();
    T_b_prev_[k] = bodies_[k].T_b_c;
  }
  for (size_t k = 0; k < kMaxBodies; ++k) {
    Body& body = bodies_[k];
    if (!body.IsThere()) continue;
    body.as_world.ExpectAs(inertial);
    const Rest rest(frame, claims);
    const MotionPrediction prediction = body.motion.Predict(dt_s);
    const auto found = aligner_.Align(body.landmarks, rest.frame, body.T_b_c, prediction, 0);
    if (found && !found->weak && found->matches.Weight() >= kMinFollowedWeight) {
      body.motion.Observe(body.T_b_c.Inverse() * found->T_odom_c, dt_s, found->covariance);
      body.T_b_c = found->T_odom_c;
      body.unseen_frames = 0;
      matches_[k] = rest.InWhole(found->matches);
      covariances_[k] = found->covariance;
      agreements_[k] = body.as_world.AgreementWith(body.T_b_c, covariances_[k]);
      equal_agreements_[k] = body.as_world.AgreementWith(body.T_b_c, covariances_[k] + of_world.covariance);
      body.as_world.Observe(body.T_b_c, covariances_[k], true, false);
      if (++body.found_frames == kMetFrames) {
        ++n_met_;
        body.middle_b = MiddleOf(body.landmarks, matches_[k]);
      }
      Mark(matches_[k].points, claims.points);
      Mark(matches_[k].lines, claims.lines);
    } else {
      body.T_b_c = body.T_b_c * prediction.T_prev_c;
      body.as_world.Miss();
      if (++body.unseen_frames > kMaxUnseenFrames) body.id = -1;
    }
  }
  for (size_t i = 0; i < kMaxBodies; ++i) {
    for (size_t j = i + 1; j < kMaxBodies; ++j) JoinParts(i, j, frame);
  }
  return claims;
}

// The front and the side of a lorry are often found one after the other: of two bodies with similar motion the smaller
// one joins the larger.
void MovingBodies::JoinParts(size_t first, size_t second, const TrackedFrame& frame) {
  const auto is_seen = [&](size_t k) { return bodies_[k].IsThere() && bodies_[k].unseen_frames == 0; };
  if (!is_seen(first) || !is_seen(second)) return;
  const bool first_is_larger = matches_[first].Weight() >= matches_[second].Weight();
  const size_t large = first_is_larger ? first : second;
  const size_t small = first_is_larger ? second : first;
  Body& whole = bodies_[large];
  Body& part = bodies_[small];
  const auto T_c_prev = [&](size_t k) { return bodies_[k].T_b_c.Inverse() * T_b_prev_[k]; };
  const double apart_px = MotionDifference_px(T_c_prev(large), T_c_prev(small), T_b_prev_[small].Inverse(), part,
                                              matches_[small], camera_);
  if (apart_px >= kAlike_px) return;
  if (!Join(static_cast<int>(large), T_b_prev_[small], part.landmarks, matches_[small], frame)) return;
  // If both were published, one of them was counted too many.
  if (std::min(part.found_frames, whole.found_frames) >= kMetFrames) --n_met_;
  // A part that was published keeps its id, even if the other part is larger.
  if (whole.found_frames < kMetFrames && part.found_frames >= kMetFrames) {
    whole.id = part.id;
    whole.middle_b = MiddleOf(whole.landmarks, matches_[large]);
  }
  whole.found_frames = std::max(whole.found_frames, part.found_frames);
  whole.doubtful_frames = std::min(whole.doubtful_frames, part.doubtful_frames);
  part.id = -1;
  matches_[small] = {};
}

FrameMatches MovingBodies::Contradicting(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                         const FrameMatches& matches, const SE3& T_odom_c) const {
  const SE3 T_c_odom = T_odom_c.Inverse();
  FrameMatches contradicting;
  for (const LandmarkMatch& match : matches.points) {
    const StereoPoint& seen = frame.features.points[match.feature];
    const Eigen::Vector3d p_c = T_c_odom * landmarks.points.landmarks()[match.landmark].p_odom;
    bool contradicts = p_c.z() < camera_.MinDepth();
    if (!contradicts) {
      const Eigen::Vector3d uvd = camera_.ProjectStereo(p_c);
      contradicts = (uvd.head<2>() - seen.left.px).norm() > kContradiction_px * seen.left.scale ||
                    (seen.HasDepth() && std::abs(uvd.z() - seen.disparity_px) >
                                            kContradiction_px + kContradictionSigmas * seen.sigma_disparity_px);
    }
    if (contradicts) contradicting.points.push_back(match);
  }
  for (const LandmarkMatch& match : matches.lines) {
    const StereoLine& seen = frame.features.lines[match.feature];
    const Segment3& segment = landmarks.lines.landmarks()[match.landmark].segment_odom;
    const auto px = ProjectSegment({T_c_odom * segment.p, T_c_odom * segment.q}, camera_, kSearchRadius_px);
    bool contradicts = !px;
    if (px) {
      const Eigen::Vector3d line = LineThrough(seen.left.segment);
      contradicts = std::max(std::abs(line.dot(px->p.homogeneous())), std::abs(line.dot(px->q.homogeneous()))) >
                    kContradiction_px;
    }
    if (contradicts) contradicting.lines.push_back(match);
  }
  return contradicting;
}

std::optional<Alignment> MovingBodies::FindSecond(const SE3& T_odom_prev, const MotionPrediction& prediction,
                                                  const LocalLandmarks& world, const TrackedFrame& frame,
                                                  const Claims& claims, const Alignment& found) const {
  // Only landmarks of the last frame: on a moving object every frame creates the same landmarks again.
  std::vector<char> points = FlagsOf(found.matches.points, &LandmarkMatch::landmark, world.points.landmarks().size());
  std::vector<char> lines = FlagsOf(found.matches.lines, &LandmarkMatch::landmark, world.lines.landmarks().size());
  const auto only_recent = [](const auto& landmarks, std::vector<char>& out) {
    for (size_t i = 0; i < out.size(); ++i) out[i] = out[i] == 0 && landmarks[i].unseen_frames == 0 ? 1 : 0;
  };
  only_recent(world.points.landmarks(), points);
  only_recent(world.lines.landmarks(), lines);
  const std::vector<int> point_places = PlacesOf(points, true);
  const std::vector<int> line_places = PlacesOf(lines, true);
  if (point_places.size() + 2 * line_places.size() < static_cast<size_t>(kMinWeight)) return std::nullopt;
  const LocalLandmarks candidates = world.Copy(points, lines);
  const Rest rest(frame, claims);

  // Searches around the positions if they stood, the last positions in the image, and the positions by the predicted
  // motion.
  const double radius_px = prediction.is_reliable ? kSearchRadius_px : 2.0 * kSearchRadius_px;
  FrameMatches matches;
  std::vector<SE3> from{found.T_odom_c, T_odom_prev};
  if (!IsExpected(found.T_odom_c, T_odom_prev, prediction)) from.push_back(T_odom_prev * prediction.T_prev_c);
  for (const SE3& T : from) {
    const FrameMatches around = aligner_.MatchByProjection(candidates, rest.frame, T, {radius_px, 0});
    AddMatches(around.points, matches.points);
    AddMatches(around.lines, matches.lines);
  }
  matches = Contradicting(candidates, rest.frame, matches, found.T_odom_c);
  matches.points = MovingTogether(candidates.points, T_odom_prev.Inverse(), matches.points, rest.frame, camera_);
  if (matches.Weight() < kMinWeight) return std::nullopt;
  const auto T_c_odom = EstimatePoseRansac(candidates.points.Observations(matches.points, rest.frame),
                                           candidates.lines.Observations(matches.lines, rest.frame), camera_,
                                           kMinWeight, kRansacInlier_px, kRansacSeed, Neighbourhood{});
  if (!T_c_odom) return std::nullopt;
  const SE3 T_odom_c = T_c_odom->Inverse();
  const FrameMatches guided = Contradicting(
      candidates, rest.frame,
      aligner_.MatchByProjection(candidates, rest.frame, T_odom_c, {2.0 * kRansacInlier_px, 0}), found.T_odom_c);
  auto second = aligner_.Estimate(candidates, rest.frame, guided, T_odom_c, std::nullopt);
  if (!second || second->matches.Weight() < kMinWeight ||
      second->matches.Weight() < kMinInlierRatio * guided.Weight()) {
    return std::nullopt;
  }
  second->matches = Renumbered(rest.InWhole(second->matches), point_places, line_places);
  return second;
}

bool MovingBodies::FindNew(const SE3& T_odom_prev, const MotionPrediction& prediction, double dt_s,
                           const DisparityCalibration& calibration, const InertialMotionModel& inertial,
                           LocalLandmarks& world, const TrackedFrame& frame, Claims& claims, Alignment& found) {
  const auto slot = std::find_if(bodies_.begin(), bodies_.end(), [](const Body& body) { return !body.IsThere(); });
  if (slot == bodies_.end()) return false;
  const auto second = FindSecond(T_odom_prev, prediction, world, frame, claims, found);
  if (!second) return false;
  const FrameMatches own = Contradicting(world, frame, found.matches, second->T_odom_c);
  if (IsDisparityOffset(T_odom_prev, world, frame, found, own, *second, calibration, camera_)) return false;
  bool guessed = false;
  const bool first_is_world =
      own.Weight() < kMinWeight || IsWorld(found, own, *second, T_odom_prev, prediction, inertial, frame, guessed);
  const FrameMatches& of_body = first_is_world ? second->matches : own;
  const int known = first_is_world ? BodyAround(of_body, found.matches, frame) : -1;
  const std::vector<char> points = FlagsOf(of_body.points, &LandmarkMatch::landmark, world.points.landmarks().size());
  const std::vector<char> lines = FlagsOf(of_body.lines, &LandmarkMatch::landmark, world.lines.landmarks().size());
  const std::vector<int> point_places = PlacesAfterTaking(points);
  const std::vector<int> line_places = PlacesAfterTaking(lines);
  LocalLandmarks taken = world.Take(points, lines);
  const FrameMatches taken_matches = Renumbered(of_body, point_places, line_places);
  Own(taken);
  Mark(of_body.points, claims.points);
  Mark(of_body.lines, claims.lines);

  if (known >= 0 && Join(known, T_odom_prev, taken, taken_matches, frame)) {
    found.matches = Renumbered(found.matches, point_places, line_places);
    return true;
  }
  // A body that went out of view there continues under its id.
  const bool continues = known >= 0 && bodies_[known].unseen_frames > 0;
  const size_t k = continues ? static_cast<size_t>(known) : static_cast<size_t>(slot - bodies_.begin());
  Body& body = bodies_[k];
  if (!continues) {
    body.id = next_body_id_++;
    body.found_frames = 1;
  }
  body.landmarks = std::move(taken);
  body.T_b_c = first_is_world ? second->T_odom_c : found.T_odom_c;
  body.motion.Forget();
  body.motion.Observe(T_odom_prev.Inverse() * body.T_b_c, dt_s,
                      first_is_world ? second->covariance : found.covariance);
  body.unseen_frames = 0;
  body.standing_frames = 0;
  if (!continues) body.doubtful_frames = guessed ? kDoubtfulFrames : 0;
  covariances_[k] = first_is_world ? second->covariance : found.covariance;
  body.as_world = inertial.For(T_odom_prev);
  body.as_world.Observe(body.T_b_c, covariances_[k], true, false);
  body.evidence = 0.0;
  T_b_prev_[k] = T_odom_prev;
  matches_[k] = taken_matches;
  body.middle_b = MiddleOf(body.landmarks, matches_[k]);

  if (first_is_world) {
    found.matches = Renumbered(found.matches, point_places, line_places);
    return true;
  }
  // Estimates the world's motion again, starting from the second motion, without the features of bodies.
  Alignment coarse = *second;
  coarse.matches = Renumbered(second->matches, point_places, line_places);
  Claims of_bodies{std::vector<char>(claims.points.size(), 0), std::vector<char>(claims.lines.size(), 0)};
  for (const FrameMatches& matches : matches_) {
    Mark(matches.points, of_bodies.points);
    Mark(matches.lines, of_bodies.lines);
  }
  const Rest rest(frame, of_bodies);
  const auto in_rest = [](const std::vector<int>& places, size_t n) {
    std::vector<int> of_whole(n, -1);
    for (size_t i = 0; i < places.size(); ++i) of_whole[places[i]] = static_cast<int>(i);
    return of_whole;
  };
  coarse.matches.points = Renumbered(coarse.matches.points, {}, in_rest(rest.points, frame.features.points.size()));
  coarse.matches.lines = Renumbered(coarse.matches.lines, {}, in_rest(rest.lines, frame.features.lines.size()));
  const MotionPrior prior{(T_odom_prev * prediction.T_prev_c).Inverse(), prediction.covariance};
  found = aligner_.Refine(world, rest.frame, coarse, prior);
  found.matches = rest.InWhole(found.matches);
  claims = of_bodies;
  Mark(found.matches.points, claims.points);
  Mark(found.matches.lines, claims.lines);
  return true;
}

/// Returns the body that surrounds most of these features, or -1.
int MovingBodies::BodyAround(const FrameMatches& matches, const FrameMatches& of_world,
                             const TrackedFrame& frame) const {
  const FeaturePlaces places = AllPlaces(of_world, frame);
  std::array<int, kMaxBodies> counts{};
  for (const LandmarkMatch& match : matches.points) {
    const StereoPoint& point = frame.features.points[match.feature];
    const int owner = places.Owner(point.left.px, point.disparity_px, 1);
    if (owner >= 0) ++counts[static_cast<size_t>(owner)];
  }
  const auto most = std::max_element(counts.begin(), counts.end());
  return 2 * *most > static_cast<int>(matches.points.size()) ? static_cast<int>(most - counts.begin()) : -1;
}

/// Adds features to a body in view if they move with it: its pose was measured at a small part and is inaccurate
/// farther away. Returns false and does nothing if they move differently.
bool MovingBodies::Join(int known, const SE3& T_odom_prev, const LocalLandmarks& taken, const FrameMatches& matches,
                        const TrackedFrame& frame) {
  Body& body = bodies_[known];
  if (body.unseen_frames > 0) return false;
  LocalLandmarks all = body.landmarks;
  const auto n_points = static_cast<int>(all.points.landmarks().size());
  const auto n_lines = static_cast<int>(all.lines.landmarks().size());
  LocalLandmarks added = taken;
  added.Move(T_b_prev_[known] * T_odom_prev.Inverse());
  all.Append(added);
  FrameMatches joined = matches_[known];
  for (const LandmarkMatch& match : matches.points)
    joined.points.push_back({match.landmark + n_points, match.feature});
  for (const LandmarkMatch& match : matches.lines) joined.lines.push_back({match.landmark + n_lines, match.feature});
  auto together = aligner_.Estimate(all, frame, joined, body.T_b_c, std::nullopt);
  if (!together || together->matches.Weight() < kMinJoinedRatio * joined.Weight()) return false;
  body.landmarks = std::move(all);
  body.T_b_c = together->T_odom_c;
  matches_[known] = std::move(together->matches);
  return true;
}

FeaturePlaces MovingBodies::AllPlaces(const FrameMatches& of_world, const TrackedFrame& frame) const {
  FeaturePlaces places;
  const auto add = [&](const FrameMatches& matches, int body) {
    for (const LandmarkMatch& match : matches.points) {
      const StereoPoint& point = frame.features.points[match.feature];
      places.Add(point.left.px, point.disparity_px, body);
    }
  };
  add(of_world, -1);
  for (size_t k = 0; k < kMaxBodies; ++k) {
    const Body& body = bodies_[k];
    if (!body.IsThere() || body.unseen_frames > kGuardedFrames) continue;
    add(matches_[k], static_cast<int>(k));
    if (body.unseen_frames == 0) continue;
    // Predicted positions of its features.
    const SE3 T_c_b = body.T_b_c.Inverse();
    for (const PointLandmark& landmark : body.landmarks.points.landmarks()) {
      const Eigen::Vector3d p_c = T_c_b * landmark.p_odom;
      if (landmark.unseen_frames > body.unseen_frames || p_c.z() < camera_.MinDepth()) continue;
      const Eigen::Vector3d uvd = camera_.ProjectStereo(p_c);
      places.Add(uvd.head<2>(), uvd.z(), static_cast<int>(k));
    }
  }
  return places;
}

// Features surrounded by a body belong to it even if they agree with the world's motion: edges that a body slides
// along.
void MovingBodies::AssignToBodies(const LocalLandmarks& world, const TrackedFrame& frame, const FeaturePlaces& places,
                                  Alignment& found) const {
  FrameMatches left;
  for (const LandmarkMatch& match : found.matches.points) {
    const StereoPoint& point = frame.features.points[match.feature];
    if (places.Owner(point.left.px, point.disparity_px, kSurroundedTimes) < 0) left.points.push_back(match);
  }
  for (const LandmarkMatch& match : found.matches.lines) {
    if (places.Owner(frame.features.lines[match.feature], kSurroundedTimes) < 0) left.lines.push_back(match);
  }
  if (left.Weight() == found.matches.Weight()) return;
  const bool weak = found.weak;
  auto again = aligner_.Estimate(world, frame, left, found.T_odom_c, std::nullopt);
  if (!again) return;
  found = std::move(*again);
  found.weak = weak;
}

void MovingBodies::NameFeatures(const FeaturePlaces& places, const FrameMatches& of_world,
                                TrackedFrame& frame) const {
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    const StereoPoint& point = frame.features.points[i];
    frame.point_tracks[i].body = places.Owner(point.left.px, point.disparity_px, 1);
  }
  for (size_t i = 0; i < frame.features.lines.size(); ++i) {
    frame.line_tracks[i].body = places.Owner(frame.features.lines[i], 1);
  }
  NameMatched(of_world, -1, frame);
}

void MovingBodies::ReleaseStandingBodies(const SE3& T_odom_prev, const SE3& T_odom_c, LocalLandmarks& world,
                                         TrackedFrame& frame) {
  for (size_t k = 0; k < kMaxBodies; ++k) {
    Body& body = bodies_[k];
    if (!body.IsThere() || body.unseen_frames > 0) continue;
    // Compares the previous positions of its points, the current ones, and those if the body had stood.
    const SE3 T_prev_b = T_b_prev_[k].Inverse();
    const SE3 T_c_b = body.T_b_c.Inverse();
    const SE3 T_c_prev = T_odom_c.Inverse() * T_odom_prev;
    std::vector<double> shown;
    std::vector<double> moved;
    for (const LandmarkMatch& match : matches_[k].points) {
      const Eigen::Vector3d& p_b = body.landmarks.points.landmarks()[match.landmark].p_odom;
      const Eigen::Vector3d before = T_prev_b * p_b;
      const Eigen::Vector3d now = T_c_b * p_b;
      const Eigen::Vector3d standing = T_c_prev * before;
      if (std::min({before.z(), now.z(), standing.z()}) < camera_.MinDepth()) continue;
      shown.push_back((camera_.ProjectStereo(standing) - camera_.ProjectStereo(before)).norm());
      moved.push_back((camera_.ProjectStereo(standing) - camera_.ProjectStereo(now)).norm());
    }
    if (moved.empty()) continue;
    const double moved_px = Median(moved);
    if (moved_px > kStandingMotion_px) {
      body.standing_frames = 0;
    } else if (Median(shown) > kShownMotion_px) {
      ++body.standing_frames;
    }
    if (body.standing_frames >= kStandingFrames) ReturnToWorld(k, T_odom_c, world, frame);
  }
}

void MovingBodies::ReturnToWorld(size_t k, const SE3& T_odom_c, LocalLandmarks& world, TrackedFrame& frame) {
  Body& body = bodies_[k];
  body.landmarks.Move(T_odom_c * body.T_b_c.Inverse());
  for (const PointLandmark& landmark : body.landmarks.points.landmarks()) {
    owned_points_.Remove(landmark.id, landmark.map_id);
  }
  for (const LineLandmark& landmark : body.landmarks.lines.landmarks()) {
    owned_lines_.Remove(landmark.id, landmark.map_id);
  }
  world.Append(body.landmarks);
  body.id = -1;
  for (std::vector<FeatureTrack>* const tracks : {&frame.point_tracks, &frame.line_tracks}) {
    for (FeatureTrack& track : *tracks) {
      if (track.body == static_cast<int>(k)) track.body = -1;
    }
  }
}

void MovingBodies::Own(const LocalLandmarks& landmarks) {
  for (const PointLandmark& landmark : landmarks.points.landmarks()) owned_points_.Add(landmark.id, landmark.map_id);
  for (const LineLandmark& landmark : landmarks.lines.landmarks()) owned_lines_.Add(landmark.id, landmark.map_id);
}

int MovingBodies::CountFeatures(const TrackedFrame& frame) const {
  const auto is_on_body = [this](const FeatureTrack& track) {
    return !track.IsOfWorld() && bodies_[track.body].found_frames >= kMetFrames;
  };
  return static_cast<int>(std::count_if(frame.point_tracks.begin(), frame.point_tracks.end(), is_on_body) +
                          std::count_if(frame.line_tracks.begin(), frame.line_tracks.end(), is_on_body));
}

std::vector<BodyPose> MovingBodies::Poses() const {
  std::vector<BodyPose> poses;
  for (size_t k = 0; k < kMaxBodies; ++k) {
    const Body& body = bodies_[k];
    if (!body.IsThere() || body.unseen_frames > 0 || body.found_frames < kMetFrames) continue;
    const SE3 T_b_body(Eigen::Quaterniond::Identity(), body.middle_b);
    const size_t n_features = matches_[k].points.size() + matches_[k].lines.size();
    poses.push_back({body.id, body.T_b_c.Inverse() * T_b_body, static_cast<int>(n_features)});
  }
  return poses;
}

void MovingBodies::LeaveOut(TrackerLocalMap& local_map) {
  owned_points_.LeaveOut(local_map.points);
  owned_lines_.LeaveOut(local_map.lines);
}

}  // namespace plslam::vo
