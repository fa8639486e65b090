#include "vo_process/tracking/moving_bodies.h"

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/features/matching/segment_projection.h"
#include "core/motion/pose_ransac.h"
#include "vo_process/tracking/landmark_list.h"

namespace plslam {
namespace {

constexpr size_t kMaxBodies = 3;
// Exclusive inliers (points + 2 x lines) that make a second motion, and those that one that is known needs to be followed.
constexpr int kMinWeight = 25;
constexpr int kMinFollowedWeight = 15;
constexpr double kMinInlierRatio = 0.5;
// A match speaks against a pose where it is off by more than this, or by so many deviations of its disparity.
constexpr double kContradiction_px = 3.0;
constexpr double kContradictionSigmas = 4.0;
// How far a feature of a body may be from where it was, or would be if it stood.
constexpr double kSearchRadius_px = 40.0;
constexpr double kRansacInlier_px = 3.0;
constexpr uint64_t kRansacSeed = 1;
// Neighbours that a match of a body has: how many, how near, and how alike they move.
constexpr int kMinTogether = 2;
constexpr double kTogetherRadius_px = 160.0;
constexpr double kTogether_px = 4.0;
constexpr double kTogetherRatio = 0.15;
// Around what a body is seen as, new features at the same depth are taken for the body's.
constexpr double kSurrounding_px = 50.0;
constexpr double kSameDepthRatio = 0.1;
constexpr double kSameDepth_px = 1.5;
// Features of the world are given to a body where so many times as many around them are the body's.
constexpr int kSurroundedTimes = 3;
// Frames out of sight after which what is near by founds landmarks of the world again, and after which a body is forgotten.
constexpr int kGuardedFrames = 5;
constexpr int kMaxUnseenFrames = 10;
// In how many frames a body must be found to be told of.
constexpr int kMetFrames = 3;
constexpr int kStandingFrames = 10;
// What would move less than this in the image, had it moved with the camera, does not show whether it stands.
constexpr double kShownMotion_px = 2.0;
constexpr double kStandingMotion_px = 0.7;
// Motions that are expected, as in `FrameAligner`, and in how many cells of the image those must be seen that agree.
constexpr double kExpectedChi2 = 25.0;
constexpr int kMinCells = 4;
constexpr double kMoreSpread = 1.5;
constexpr int kColumns = 8;
constexpr int kRows = 6;
constexpr int kMinInOctave = 3;

std::vector<char> FlagsOf(const std::vector<LandmarkMatch>& matches, int LandmarkMatch::*member, size_t n) {
  std::vector<char> flags(n, 0);
  for (const LandmarkMatch& match : matches) flags[match.*member] = 1;
  return flags;
}

void Mark(const std::vector<LandmarkMatch>& matches, std::vector<char>& claimed) {
  for (const LandmarkMatch& match : matches) claimed[match.feature] = 1;
}

// Adds those that are not there yet.
void AddMatches(const std::vector<LandmarkMatch>& more, std::vector<LandmarkMatch>& matches) {
  for (const LandmarkMatch& match : more) {
    const bool known = std::any_of(matches.begin(), matches.end(), [&](const LandmarkMatch& m) {
      return m.landmark == match.landmark && m.feature == match.feature;
    });
    if (!known) matches.push_back(match);
  }
}

std::vector<LandmarkMatch> Renumbered(const std::vector<LandmarkMatch>& matches, const std::vector<int>& landmarks,
                                      const std::vector<int>& features) {
  std::vector<LandmarkMatch> result;
  result.reserve(matches.size());
  for (const LandmarkMatch& match : matches) {
    result.push_back({landmarks.empty() ? match.landmark : landmarks[match.landmark],
                      features.empty() ? match.feature : features[match.feature]});
  }
  return result;
}

FrameMatches Renumbered(const FrameMatches& matches, const std::vector<int>& points, const std::vector<int>& lines) {
  return {Renumbered(matches.points, points, {}), Renumbered(matches.lines, lines, {})};
}

template <class Feature>
std::vector<Feature> Chosen(const std::vector<Feature>& features, const std::vector<int>& which) {
  std::vector<Feature> chosen;
  chosen.reserve(which.size());
  for (const int i : which) chosen.push_back(features[i]);
  return chosen;
}

std::vector<int> Unflagged(const std::vector<char>& flags) {
  std::vector<int> places;
  for (size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] == 0) places.push_back(static_cast<int>(i));
  }
  return places;
}

double MiddleDisparity(const StereoLine& line) {
  return line.HasDepth() ? 0.5 * (line.disparity_p_px + line.disparity_q_px) : -1.0;
}

// How widely what agrees with a motion is spread: cells of the image times octaves of depth.
struct Spread {
  int cells = 0;
  int octaves = 0;
  int Score() const { return cells * octaves; }
};

Spread SpreadOf(const FrameMatches& matches, const TrackedFrame& frame, const StereoCamera& camera) {
  std::set<int> cells;
  std::array<int, 16> in_octave{};
  const auto add = [&](const Eigen::Vector2d& px, double disparity_px) {
    const int x = std::clamp(static_cast<int>(px.x() * kColumns / camera.width_px), 0, kColumns - 1);
    const int y = std::clamp(static_cast<int>(px.y() * kRows / camera.height_px), 0, kRows - 1);
    cells.insert(y * kColumns + x);
    if (disparity_px > 0.0) ++in_octave[std::clamp(static_cast<int>(std::log2(disparity_px)) + 4, 0, 15)];
  };
  for (const LandmarkMatch& match : matches.points) {
    const StereoPoint& point = frame.features.points[match.feature];
    add(point.left.px, point.disparity_px);
  }
  for (const LandmarkMatch& match : matches.lines) {
    const StereoLine& line = frame.features.lines[match.feature];
    add(0.5 * (line.left.segment.p + line.left.segment.q), MiddleDisparity(line));
  }
  const auto octaves =
      std::count_if(in_octave.begin(), in_octave.end(), [](int n) { return n >= kMinInOctave; });
  return {static_cast<int>(cells.size()), static_cast<int>(octaves)};
}

bool IsExpected(const SE3& T_odom_c, const SE3& T_odom_prev, const MotionPrediction& prediction) {
  const Vector6d off = ((T_odom_prev * prediction.T_prev_c).Inverse() * T_odom_c).Log();
  return off.dot(prediction.covariance.ldlt().solve(off)) <= kExpectedChi2;
}

// Matches that went the same way in the image as some that are near by at the same depth: wrong ones go anywhere. `T_c_odom` is
// where the landmarks were seen from before.
std::vector<LandmarkMatch> MovingTogether(const PointLandmarks& landmarks, const SE3& T_c_odom,
                                          const std::vector<LandmarkMatch>& matches, const TrackedFrame& frame,
                                          const StereoCamera& camera) {
  struct Flow {
    Eigen::Vector2d px;
    Eigen::Vector2d moved_px;
    double disparity_px;
  };
  std::vector<Flow> flows;
  flows.reserve(matches.size());
  for (const LandmarkMatch& match : matches) {
    const StereoPoint& seen = frame.features.points[match.feature];
    const Eigen::Vector3d uvd = camera.ProjectStereo(T_c_odom * landmarks.landmarks()[match.landmark].p_odom);
    flows.push_back({seen.left.px, seen.left.px - uvd.head<2>(), uvd.z()});
  }
  std::vector<LandmarkMatch> together;
  for (size_t i = 0; i < flows.size(); ++i) {
    int near = 0;
    for (size_t j = 0; j < flows.size() && near < kMinTogether; ++j) {
      const double allowed_px = kTogether_px + kTogetherRatio * flows[i].moved_px.norm();
      if (i != j && (flows[i].px - flows[j].px).norm() < kTogetherRadius_px &&
          (flows[i].moved_px - flows[j].moved_px).norm() < allowed_px &&
          std::abs(flows[i].disparity_px - flows[j].disparity_px) < kSameDepth_px + 0.3 * flows[i].disparity_px) {
        ++near;
      }
    }
    if (near >= kMinTogether) together.push_back(matches[i]);
  }
  return together;
}

}  // namespace

struct MovingBodies::Rest {
  Rest(const TrackedFrame& whole, const Claims& claims)
      : points(Unflagged(claims.points)),
        lines(Unflagged(claims.lines)),
        frame({Chosen(whole.features.points, points), Chosen(whole.features.lines, lines)}) {
    frame.point_sigma_scale = whole.point_sigma_scale;
  }

  FrameMatches InWhole(const FrameMatches& matches) const {
    return {Renumbered(matches.points, {}, points), Renumbered(matches.lines, {}, lines)};
  }

  /// Places of the features in the whole frame.
  std::vector<int> points;
  std::vector<int> lines;
  TrackedFrame frame;
};

struct MovingBodies::Second {
  /// Matches of landmarks of the world with features of the whole frame, all of which contradict the first motion.
  Alignment alignment;
};

struct MovingBodies::Places {
  struct Place {
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    double disparity_px = -1.0;
    int body = -1;
  };
  using Counts = std::array<int, kMaxBodies + 1>;

  void Add(const Eigen::Vector2d& px, double disparity_px, int body) { places.push_back({px, disparity_px, body}); }

  /// How many around are of each body, by slot, and, behind these, of the world; the place itself is not counted.
  Counts Around(const Eigen::Vector2d& px, double disparity_px) const {
    Counts counts{};
    for (const Place& place : places) {
      const double squared = (place.px - px).squaredNorm();
      if (squared > kSurrounding_px * kSurrounding_px || squared == 0.0) continue;
      const double allowed = kSameDepth_px + kSameDepthRatio * std::max(disparity_px, place.disparity_px);
      const bool comparable = disparity_px > 0.0 && place.disparity_px > 0.0;
      if (comparable && std::abs(place.disparity_px - disparity_px) > allowed) continue;
      ++counts[place.body < 0 ? kMaxBodies : static_cast<size_t>(place.body)];
    }
    return counts;
  }

  /// The body that has more than `times` as many there as the world, or -1.
  int Owner(const Eigen::Vector2d& px, double disparity_px, int times) const {
    const Counts counts = Around(px, disparity_px);
    const auto most = std::max_element(counts.begin(), counts.begin() + kMaxBodies);
    if (*most < 2 || *most <= times * counts[kMaxBodies]) return -1;
    return static_cast<int>(most - counts.begin());
  }

  /// Of a line the body that owns at least two of both ends and the middle.
  int Owner(const StereoLine& line, int times) const {
    const Segment2& segment = line.left.segment;
    const std::array<int, 3> owners{
        Owner(segment.p, line.HasDepth() ? line.disparity_p_px : -1.0, times),
        Owner(0.5 * (segment.p + segment.q), MiddleDisparity(line), times),
        Owner(segment.q, line.HasDepth() ? line.disparity_q_px : -1.0, times)};
    if (owners[0] == owners[1] || owners[0] == owners[2]) return owners[0];
    return owners[1] == owners[2] ? owners[1] : -1;
  }

  std::vector<Place> places;
};

MovingBodies::MovingBodies(const StereoCamera& camera, const VoOptions& options)
    : camera_(camera),
      aligner_(camera, options),
      bodies_(kMaxBodies, Body(camera, options)),
      matches_(kMaxBodies),
      T_b_prev_(kMaxBodies) {}

void MovingBodies::Forget() {
  for (Body& body : bodies_) body.id = -1;
}

std::optional<SE3> MovingBodies::Separate(const SE3& T_odom_prev, const MotionPrediction& prediction, double dt_s,
                                          LocalLandmarks& world, TrackedFrame& frame, Alignment& found) {
  for (size_t k = 0; k < kMaxBodies; ++k) {
    matches_[k] = {};
    T_b_prev_[k] = bodies_[k].T_b_c;
  }
  Claims claims{FlagsOf(found.matches.points, &LandmarkMatch::feature, frame.features.points.size()),
                FlagsOf(found.matches.lines, &LandmarkMatch::feature, frame.features.lines.size())};
  Follow(dt_s, frame, claims);
  std::optional<SE3> rival;
  while (FindNew(T_odom_prev, prediction, dt_s, world, frame, claims, found, rival)) {
  }
  if (std::none_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return body.IsThere(); })) return rival;
  const Places places = AllPlaces(found, frame);
  GiveToBodies(world, frame, places, found);
  NameFeatures(places, found, frame);
  for (size_t k = 0; k < kMaxBodies; ++k) {
    Body& body = bodies_[k];
    if (!body.IsThere()) continue;
    body.landmarks.Update(body.T_b_c, matches_[k], frame);
    for (const LandmarkMatch& match : matches_[k].points) frame.point_tracks[match.feature].body = static_cast<int>(k);
    for (const LandmarkMatch& match : matches_[k].lines) frame.line_tracks[match.feature].body = static_cast<int>(k);
    if (body.unseen_frames > 0) continue;
    body.landmarks.NumberBehind(world);
    body.landmarks.Found(body.T_b_c, frame, static_cast<int>(k));
    world.NumberBehind(body.landmarks);
  }
  LetStandingGo(T_odom_prev, found.T_odom_c, world, frame);
  return rival;
}

// Bodies that are known, among what the world has left over.
void MovingBodies::Follow(double dt_s, const TrackedFrame& frame, Claims& claims) {
  for (size_t k = 0; k < kMaxBodies; ++k) {
    Body& body = bodies_[k];
    if (!body.IsThere()) continue;
    const Rest rest(frame, claims);
    const MotionPrediction prediction = body.motion.Predict(dt_s);
    const auto found = aligner_.Align(body.landmarks, rest.frame, body.T_b_c, prediction, 0);
    if (found && !found->weak && found->matches.Weight() >= kMinFollowedWeight) {
      body.motion.Observe(body.T_b_c.Inverse() * found->T_odom_c, dt_s, found->covariance);
      body.T_b_c = found->T_odom_c;
      body.unseen_frames = 0;
      if (++body.found_frames == kMetFrames) ++n_met_;
      matches_[k] = rest.InWhole(found->matches);
      Mark(matches_[k].points, claims.points);
      Mark(matches_[k].lines, claims.lines);
    } else {
      body.T_b_c = body.T_b_c * prediction.T_prev_c;
      if (++body.unseen_frames > kMaxUnseenFrames) body.id = -1;
    }
  }
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

std::optional<MovingBodies::Second> MovingBodies::FindSecond(const SE3& T_odom_prev,
                                                             const MotionPrediction& prediction,
                                                             const LocalLandmarks& world, const TrackedFrame& frame,
                                                             const Claims& claims, const Alignment& found) const {
  // Only what the last frame saw: of a thing that moves, every frame founds the same landmarks anew.
  std::vector<char> points = FlagsOf(found.matches.points, &LandmarkMatch::landmark, world.points.landmarks().size());
  std::vector<char> lines = FlagsOf(found.matches.lines, &LandmarkMatch::landmark, world.lines.landmarks().size());
  const auto only_recent = [](const auto& landmarks, std::vector<char>& out) {
    for (size_t i = 0; i < out.size(); ++i) out[i] = out[i] == 0 && landmarks[i].unseen_frames == 0 ? 1 : 0;
  };
  only_recent(world.points.landmarks(), points);
  only_recent(world.lines.landmarks(), lines);
  const auto n_points = std::count(points.begin(), points.end(), 1);
  const auto n_lines = std::count(lines.begin(), lines.end(), 1);
  if (n_points + 2 * n_lines < kMinWeight) return std::nullopt;
  const auto places = [](const std::vector<char>& flags) {
    std::vector<int> which;
    for (size_t i = 0; i < flags.size(); ++i) {
      if (flags[i] != 0) which.push_back(static_cast<int>(i));
    }
    return which;
  };
  const std::vector<int> point_places = places(points);
  const std::vector<int> line_places = places(lines);
  const LocalLandmarks candidates = world.Copy(points, lines);
  const Rest rest(frame, claims);

  // Where they would be if they stood, where they were last seen in the image, and where the motion so far would have them.
  const double radius_px = prediction.goes_on ? kSearchRadius_px : 2.0 * kSearchRadius_px;
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
  const FrameMatches guided =
      Contradicting(candidates, rest.frame,
                    aligner_.MatchByProjection(candidates, rest.frame, T_odom_c, {2.0 * kRansacInlier_px, 0}),
                    found.T_odom_c);
  auto second = aligner_.Estimate(candidates, rest.frame, guided, T_odom_c, std::nullopt);
  if (!second || second->matches.Weight() < kMinWeight ||
      second->matches.Weight() < kMinInlierRatio * guided.Weight()) {
    return std::nullopt;
  }
  second->matches = Renumbered(rest.InWhole(second->matches), point_places, line_places);
  return Second{std::move(*second)};
}

// Of two motions: is the first the world's?
bool MovingBodies::IsWorld(const Alignment& found, const FrameMatches& own, const Second& second,
                           const SE3& T_odom_prev, const MotionPrediction& prediction, const TrackedFrame& frame,
                           bool& guessed) const {
  const Spread first_spread = SpreadOf(own, frame, camera_);
  const Spread second_spread = SpreadOf(second.alignment.matches, frame, camera_);
  if (!prediction.goes_on) {
    guessed = true;
    return first_spread.Score() >= second_spread.Score();
  }
  const bool first_goes_on = IsExpected(found.T_odom_c, T_odom_prev, prediction);
  const bool second_goes_on =
      IsExpected(second.alignment.T_odom_c, T_odom_prev, prediction) && second_spread.cells >= kMinCells;
  if (first_goes_on != second_goes_on) return first_goes_on;
  if (!second_goes_on) {
    guessed = true;
    return first_spread.Score() >= second_spread.Score();
  }
  return second_spread.Score() <= kMoreSpread * first_spread.Score();
}

bool MovingBodies::FindNew(const SE3& T_odom_prev, const MotionPrediction& prediction, double dt_s,
                           LocalLandmarks& world, const TrackedFrame& frame, Claims& claims, Alignment& found,
                           std::optional<SE3>& rival) {
  const auto slot = std::find_if(bodies_.begin(), bodies_.end(), [](const Body& body) { return !body.IsThere(); });
  if (slot == bodies_.end()) return false;
  const auto second = FindSecond(T_odom_prev, prediction, world, frame, claims, found);
  if (!second) return false;
  const auto k = static_cast<size_t>(slot - bodies_.begin());
  const FrameMatches own = Contradicting(world, frame, found.matches, second->alignment.T_odom_c);
  bool guessed = false;
  const bool first_is_world = own.Weight() < kMinWeight ||
                              IsWorld(found, own, *second, T_odom_prev, prediction, frame, guessed);
  if (guessed) rival = first_is_world ? second->alignment.T_odom_c : found.T_odom_c;
  const FrameMatches& of_body = first_is_world ? second->alignment.matches : own;
  const std::vector<char> points = FlagsOf(of_body.points, &LandmarkMatch::landmark, world.points.landmarks().size());
  const std::vector<char> lines = FlagsOf(of_body.lines, &LandmarkMatch::landmark, world.lines.landmarks().size());
  const std::vector<int> point_places = PlacesAfterTaking(points);
  const std::vector<int> line_places = PlacesAfterTaking(lines);

  Body& body = *slot;
  body.id = next_body_id_++;
  body.landmarks = world.Take(points, lines);
  body.T_b_c = first_is_world ? second->alignment.T_odom_c : found.T_odom_c;
  body.motion.Forget();
  body.motion.Observe(T_odom_prev.Inverse() * body.T_b_c, dt_s,
                      first_is_world ? second->alignment.covariance : found.covariance);
  body.found_frames = 1;
  body.unseen_frames = 0;
  body.standing_frames = 0;
  T_b_prev_[k] = T_odom_prev;
  matches_[k] = Renumbered(of_body, point_places, line_places);
  Own(body.landmarks);
  Mark(of_body.points, claims.points);
  Mark(of_body.lines, claims.lines);

  if (first_is_world) {
    found.matches = Renumbered(found.matches, point_places, line_places);
    return true;
  }
  // The world anew, from the second motion on, among what is not the body's.
  Alignment coarse = second->alignment;
  coarse.matches = Renumbered(second->alignment.matches, point_places, line_places);
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

MovingBodies::Places MovingBodies::AllPlaces(const Alignment& found, const TrackedFrame& frame) const {
  Places places;
  const auto add = [&](const FrameMatches& matches, int body) {
    for (const LandmarkMatch& match : matches.points) {
      const StereoPoint& point = frame.features.points[match.feature];
      places.Add(point.left.px, point.disparity_px, body);
    }
  };
  add(found.matches, -1);
  for (size_t k = 0; k < kMaxBodies; ++k) {
    const Body& body = bodies_[k];
    if (!body.IsThere() || body.unseen_frames > kGuardedFrames) continue;
    add(matches_[k], static_cast<int>(k));
    if (body.unseen_frames == 0) continue;
    // Where it should be.
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

// What a body surrounds is not the world's, though it agrees with its motion: edges along which a body slides.
void MovingBodies::GiveToBodies(const LocalLandmarks& world, const TrackedFrame& frame, const Places& places,
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

void MovingBodies::NameFeatures(const Places& places, const Alignment& found, TrackedFrame& frame) const {
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    const StereoPoint& point = frame.features.points[i];
    frame.point_tracks[i].body = places.Owner(point.left.px, point.disparity_px, 1);
  }
  for (size_t i = 0; i < frame.features.lines.size(); ++i) {
    frame.line_tracks[i].body = places.Owner(frame.features.lines[i], 1);
  }
  for (const LandmarkMatch& match : found.matches.points) frame.point_tracks[match.feature].body = -1;
  for (const LandmarkMatch& match : found.matches.lines) frame.line_tracks[match.feature].body = -1;
}

void MovingBodies::LetStandingGo(const SE3& T_odom_prev, const SE3& T_odom_c, LocalLandmarks& world,
                                 TrackedFrame& frame) {
  for (size_t k = 0; k < kMaxBodies; ++k) {
    Body& body = bodies_[k];
    if (!body.IsThere() || body.unseen_frames > 0) continue;
    // Where its points were in the camera before, where they are, and where they would be now had the body stood.
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
    const auto median = [](std::vector<double>& values) {
      const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
      std::nth_element(values.begin(), middle, values.end());
      return *middle;
    };
    const double moved_px = median(moved);
    if (moved_px > kStandingMotion_px) {
      body.standing_frames = 0;
    } else if (median(shown) > kShownMotion_px) {
      ++body.standing_frames;
    }
    if (body.standing_frames < kStandingFrames) continue;
    body.landmarks.Move(T_odom_c * T_c_b);
    for (const PointLandmark& landmark : body.landmarks.points.landmarks()) {
      owned_points_.Remove(landmark.id, landmark.map_id);
    }
    for (const LineLandmark& landmark : body.landmarks.lines.landmarks()) {
      owned_lines_.Remove(landmark.id, landmark.map_id);
    }
    world.Append(body.landmarks);
    body.id = -1;
    for (FeatureTrack& track : frame.point_tracks) {
      if (track.body == static_cast<int>(k)) track.body = -1;
    }
    for (FeatureTrack& track : frame.line_tracks) {
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

namespace {

template <class Landmark>
void LeaveOutOwned(OwnedIds& owned, std::vector<Adopted<Landmark>>& adopted) {
  std::erase_if(adopted, [&owned](const Adopted<Landmark>& entry) {
    const auto& ids = entry.tracker_ids;
    const auto on_body = std::find_if(ids.begin(), ids.end(), [&owned](int64_t id) { return owned.Has(id); });
    const bool is_owned = on_body != ids.end() || owned.HasOfMap(entry.landmark->id);
    if (on_body != ids.end()) owned.Add(*on_body, entry.landmark->id);
    return is_owned;
  });
}

}  // namespace

void MovingBodies::LeaveOut(MapPatch& patch) {
  LeaveOutOwned(owned_points_, patch.points);
  LeaveOutOwned(owned_lines_, patch.lines);
}

}  // namespace plslam
