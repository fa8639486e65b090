// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/mapper.h"

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "core/geometry/symmetric.h"
#include "core/localisation/pose_refinement.h"
#include "core/map/map_graph.h"
#include "core/optim/pose_graph/map_pose_graph.h"
#include "mapping_process/corrections/closure_check.h"
#include "mapping_process/corrections/correction.h"
#include "mapping_process/corrections/loop_fusion.h"
#include "mapping_process/insertion/duplicates.h"
#include "mapping_process/insertion/forgetting.h"
#include "mapping_process/insertion/line_extent.h"
#include "mapping_process/insertion/line_triangulation.h"
#include "mapping_process/insertion/local_window.h"
#include "mapping_process/insertion/loop_edges.h"
#include "mapping_process/insertion/observations.h"

namespace plslam::mapping {
namespace {

// Newest keyframes of a session that are never redundant: the tracker's next frames depend on them.
constexpr int kNewestKept = 3;

template <class Type>
void AddObservations(KeyframeId keyframe_id, const std::vector<LandmarkId>& association,
                     const KeyframeFeatures& features, Map& map) {
  for (int32_t i = 0; i < static_cast<int32_t>(association.size()); ++i) {
    const LandmarkId id = association[static_cast<size_t>(i)];
    if (id >= 0) AddObservation<Type>(id, {keyframe_id, i}, features, map);
  }
}

// Returns the tracker's covariance of a motion, or the identity (a metre, a radian) if it is not finite or not
// positive definite.
Matrix6d UsableCovariance(const Matrix6d& covariance) {
  const bool usable = covariance.allFinite() && IsPositiveDefinite<6>(covariance);
  return usable ? covariance : Matrix6d(Matrix6d::Identity());
}

// Widens the covariance of a recovered tracker's motion: an error far beyond its sigmas is added as one more sigma.
Matrix6d Widened(const Matrix6d& covariance, const SE3& error) {
  constexpr double kDoubted2 = 50.0;
  const Vector6d e = error.Log();
  const double chi2 = SquaredMahalanobis<6>(e, covariance);
  return chi2 <= kDoubted2 ? covariance : Matrix6d(covariance + Matrix6d(e.cwiseAbs2().asDiagonal()));
}

template <class Type>
void RemoveUnlessBelieved(const std::vector<LandmarkId>& ids, Map& map) {
  constexpr size_t kBelievedObservations = 8;
  for (const LandmarkId id : ids) {
    const auto* const landmark = Type::Find(map, id);
    if (landmark != nullptr && landmark->observations.size() < kBelievedObservations) Type::Remove(id, map);
  }
}

void Append(const std::vector<LandmarkId>& more, std::vector<LandmarkId>& ids) {
  ids.insert(ids.end(), more.begin(), more.end());
}

}  // namespace

Mapper::Mapper(const StereoCamera& camera, const MappingOptions& options, StoredMap stored)
    : camera_(camera),
      options_(options),
      map_(std::move(stored.map)),
      features_(std::move(stored.features)),
      landmark_ids_{stored.next_point_id, stored.next_line_id},
      next_keyframe_id_(stored.next_keyframe_id),
      newest_session_(stored.newest_session),
      newest_t_ns_(stored.newest_t_ns),
      version_{.map = {}, .numbering = {}, .number = stored.version} {
  map_.SetCamera(camera);
  for (const auto& [session, newest] : stored.sessions) {
    sessions_[session] = {newest.keyframe_id, newest.session_keyframe_id};
  }
}

Mapper::Mapper(const StereoCamera& camera, const MappingOptions& options, MapperState state)
    : Mapper(camera, options, std::move(state.stored)) {
  recent_landmarks_ = std::move(state.recent_landmarks);
  missed_landmarks_ = std::move(state.missed_landmarks);
  visits_ = std::move(state.visits);
  inertial_links_ = std::move(state.inertial_links);
  tracker_ = std::move(state.tracker);
  figures_ = state.figures;
  committed_ = state.committed != 0;
  structural_version_ = state.structural_version;
  options_.localise_only = state.localise_only != 0;
  version_.map = state.map_id;
}

StoredMap Mapper::Store() {
  recent_landmarks_ = {};
  return Stored();
}

void Mapper::LendStored(const std::function<void(StoredMap&)>& use) {
  LendState([&use](MapperState& state) { use(state.stored); });
  recent_landmarks_ = {};
}

MapperState Mapper::State() const {
  return {.stored = Stored(),
          .recent_landmarks = recent_landmarks_,
          .missed_landmarks = missed_landmarks_,
          .visits = visits_,
          .inertial_links = inertial_links_,
          .tracker = tracker_,
          .figures = figures_,
          .committed = committed_ ? uint8_t{1} : uint8_t{0},
          .structural_version = structural_version_,
          .localise_only = options_.localise_only ? uint8_t{1} : uint8_t{0},
          .map_id = version_.map,
          .lockstep = 0,
          .closures = 0,
          .answer = {}};
}

void Mapper::LendState(const std::function<void(MapperState&)>& use) {
  // Map and features are moved, not copied.
  Map map = std::exchange(map_, {});
  KeyframeFeatures features = std::exchange(features_, {});
  MapperState state = State();
  state.stored.map = std::move(map);
  state.stored.features = std::move(features);
  const auto take_back = [&] {
    map_ = std::move(state.stored.map);
    features_ = std::move(state.stored.features);
  };
  try {
    use(state);
  } catch (...) {
    take_back();
    throw;
  }
  take_back();
}

void Mapper::Precede(MapperState& next) const {
  next.stored.version = next.structural_version = version_.number + 1;
  next.map_id = version_.map.Next();
  next.stored.next_keyframe_id = std::max(next.stored.next_keyframe_id, next_keyframe_id_);
  next.stored.next_point_id = std::max(next.stored.next_point_id, landmark_ids_.next_point);
  next.stored.next_line_id = std::max(next.stored.next_line_id, landmark_ids_.next_line);
  next.committed = 1;
  next.localise_only = options_.localise_only ? 1 : 0;
}

StoredMap Mapper::Stored() const {
  StoredMap stored;
  stored.map = map_;
  stored.features = features_;
  stored.next_keyframe_id = next_keyframe_id_;
  stored.next_point_id = landmark_ids_.next_point;
  stored.next_line_id = landmark_ids_.next_line;
  for (const auto& [session, newest] : sessions_) {
    stored.sessions[session] = {newest.keyframe_id, newest.session_keyframe_id};
  }
  stored.newest_session = newest_session_;
  stored.newest_t_ns = newest_t_ns_;
  stored.version = version_.number;
  return stored;
}

MapKeyframe Mapper::Prepare(const Keyframe& keyframe) const {
  MapKeyframe entry;
  entry.id = next_keyframe_id_;
  entry.name = keyframe.name;
  entry.frame_id = keyframe.frame_id;
  entry.t_ns = keyframe.t_ns;
  entry.T_odom_kf = keyframe.T_odom_kf;
  entry.up = keyframe.up;
  const auto session = sessions_.find(keyframe.name.session);
  if (session != sessions_.end() && session->second.keyframe_id >= 0) {
    const MapKeyframe& previous = *map_.FindKeyframe(session->second.keyframe_id);
    entry.previous_id = previous.id;
    entry.T_prevkf_kf = previous.T_odom_kf.Inverse() * keyframe.T_odom_kf;
    // The message's covariance is of the last step only; steps of missing keyframes count as equal.
    const auto steps = static_cast<double>(keyframe.name.number - session->second.session_keyframe_id);
    entry.relative_covariance = std::max(1.0, steps) * UsableCovariance(keyframe.covariance);
    entry.T_w_kf = previous.T_w_kf * entry.T_prevkf_kf;
    entry.covariance = ComposeCovariance(previous.covariance, entry.T_prevkf_kf, entry.relative_covariance);
  } else if (!map_.keyframes().empty()) {
    entry.T_w_kf = map_.keyframes().rbegin()->second.T_w_kf;
    entry.covariance = map_.keyframes().rbegin()->second.covariance + Matrix6d::Identity();
  } else {
    entry.T_w_kf = keyframe.T_odom_kf;
  }
  return entry;
}

bool Mapper::Insert(const Keyframe& keyframe, std::string* reason) {
  if (options_.localise_only) {
    *reason = fmt::format("keyframe {} of session {}: the map is fixed (mapping.localise_only)", keyframe.name.number,
                          keyframe.name.session);
    return false;
  }
  const auto session = sessions_.find(keyframe.name.session);
  if (session != sessions_.end() && keyframe.name.number <= session->second.session_keyframe_id) {
    *reason =
        fmt::format("keyframe {} of session {} is in the map already", keyframe.name.number, keyframe.name.session);
    return false;
  }
  Withdraw(keyframe);
  MapKeyframe entry = Prepare(keyframe);
  Association association = tracker_.Associations(keyframe, map_);
  const Matrix6d pose_covariance = Join(keyframe, entry, association);
  if (keyframe.state == kRecovered && entry.previous_id >= 0) {
    const SE3 T_w_predicted = map_.FindKeyframe(entry.previous_id)->T_w_kf * entry.T_prevkf_kf;
    entry.relative_covariance = Widened(entry.relative_covariance, T_w_predicted.Inverse() * entry.T_w_kf);
  }
  Put(keyframe, entry, association);
  NewLandmarks created = CreateLandmarks(entry.id, keyframe.features, CameraOf(keyframe.features, camera_),
                                         options_.insertion, landmark_ids_, map_);
  Append(TriangulateLines(entry.id, pose_covariance, features_, camera_, options_, landmark_ids_, map_),
         created.lines);
  MergeWithNeighbours(entry.id, features_, camera_, options_, map_);
  missed_landmarks_.Compare(entry.id, visits_, CameraOf(keyframe.features, camera_), map_);
  recent_landmarks_.Begin(created, entry.name.session);
  inertial_links_.Add(entry, keyframe.inertial, map_);
  tracker_.Learn(keyframe, map_.LandmarksOf(entry.id));
  sessions_[keyframe.name.session] = {entry.id, keyframe.name.number};
  newest_session_ = keyframe.name.session;
  newest_t_ns_ = keyframe.t_ns;
  next_keyframe_id_ = entry.id;
  ++next_keyframe_id_;
  committed_ = false;
  return true;
}

/// Removes landmarks that turned out to be on a moving body. A landmark with many observations is kept: a moving body
/// would not have stayed at its position.
void Mapper::Withdraw(const Keyframe& keyframe) {
  RemoveUnlessBelieved<PointType>(tracker_.WithdrawnPoints(keyframe), map_);
  RemoveUnlessBelieved<LineType>(tracker_.WithdrawnLines(keyframe), map_);
}

void Mapper::Put(const Keyframe& keyframe, const MapKeyframe& entry, const Association& association) {
  map_.Put(entry);
  features_[entry.id] = keyframe.features;
  AddObservations<PointType>(entry.id, association.points, features_, map_);
  AddObservations<LineType>(entry.id, association.lines, features_, map_);
  MapKeyframe with_parent = entry;
  // One or two wrong landmarks must not make a distant keyframe the parent.
  const std::vector<Map::Neighbour> neighbours = map_.Neighbours(entry.id, Map::kParent);
  with_parent.parent_id = neighbours.empty() ? entry.previous_id : neighbours.front().keyframe_id;
  if (with_parent.parent_id >= 0) map_.Put(with_parent);
  visits_.Add(with_parent);
}

void Mapper::Adjust(const std::atomic<bool>* stop) { AdjustAround(sessions_.at(newest_session_).keyframe_id, stop); }

void Mapper::AdjustAround(KeyframeId keyframe_id, const std::atomic<bool>* stop) {
  MapBundle window = MakeLocalWindow(keyframe_id, map_, features_, visits_, camera_, options_.window);
  inertial_links_.AddTo(window, map_);
  const BundleResult result = Adjusted(window, stop);
  figures_ = ApplyAdjustment(window, result, features_, map_);
  if (result.ok) ExtendAndTrim(window.lines, features_, camera_, map_);
}

BundleResult Mapper::Adjusted(const MapBundle& window, const std::atomic<bool>* stop) {
  BundleResult result = AdjustBundle(window.problem, options_.bundle, stop);
  const bool is_empty = window.points.empty() && window.lines.empty();
  if (!result.ok && !is_empty) {
    ++failures_.count;
    failures_.last = result.reason;
  }
  return result;
}

bool Mapper::Correct(const LoopClosure& closure, std::string* reason) {
  if (closure.kind == LoopClosure::Kind::kNone) return true;
  if (options_.localise_only) {
    *reason = "the map is fixed (mapping.localise_only)";
    return false;
  }
  *reason = WhyNotOfMap(closure, {next_keyframe_id_, landmark_ids_, version_, structural_version_}, map_);
  if (!reason->empty()) return false;
  const LandmarksNamed worse = MoveKeyframes(PosesAfter(closure.poses, map_), features_, camera_, map_);
  if (closure.kind == LoopClosure::Kind::kLoop) {
    CloseLoop(closure);
  } else {
    const MapBundle window = MakeLandmarkWindow(worse, map_, features_, camera_);
    figures_ = ApplyAdjustment(window, Adjusted(window, nullptr), features_, map_);
  }
  // Covariances composed along odometry would not include the information of the loop.
  if (!map_.loops().empty()) map_.SetCovariances(CovariancesAround(map_.loops().back().keyframe_id, map_));
  return true;
}

void Mapper::CloseLoop(const LoopClosure& closure) {
  structural_version_ = version_.number + 1;
  std::vector<LoopSides> sides;
  for (const LoopEdge& edge : EdgesInMap(closure, map_)) {
    map_.Add(edge);
    sides.push_back(SidesOf(edge, options_.window.min_shared, map_));
  }
  FusePairs(closure.points, closure.lines, features_, map_);
  for (size_t i = 0; i < sides.size(); ++i) {
    if (sides[i].new_side.empty()) continue;
    MergeSides(sides[i], features_, camera_, options_, map_);
    AdjustAround(sides[i].new_side.front(), nullptr);
  }
}

bool Mapper::IsAmongNewest(const MapKeyframe& keyframe) const {
  const auto session = sessions_.find(keyframe.name.session);
  const MapKeyframe* newest = session == sessions_.end() ? nullptr : map_.FindKeyframe(session->second.keyframe_id);
  for (int i = 0; i < kNewestKept && newest != nullptr; ++i) {
    if (newest->id == keyframe.id) return true;
    newest = map_.FindKeyframe(newest->previous_id);
  }
  return false;
}

void Mapper::Cull() {
  recent_landmarks_.Cull(options_.culling, visits_, map_);
  std::vector<KeyframeId> candidates;
  for (const Map::Neighbour& neighbour :
       map_.Neighbours(KeyframeId(next_keyframe_id_.value - 1), options_.window.min_shared)) {
    if (!IsAmongNewest(*map_.FindKeyframe(neighbour.keyframe_id))) candidates.push_back(neighbour.keyframe_id);
  }
  // Keyframes of this visit first, then earlier ones from the newest on: older ones define the place, and newer ones
  // have inherited their errors.
  std::sort(candidates.begin(), candidates.end());
  const MapKeyframe& newest = *map_.FindKeyframe(KeyframeId(next_keyframe_id_.value - 1));
  const auto earlier = std::stable_partition(candidates.begin(), candidates.end(), [&](KeyframeId id) {
    return !visits_.IsBefore(*map_.FindKeyframe(id), newest);
  });
  std::reverse(earlier, candidates.end());
  for (const KeyframeId id : RemoveRedundantKeyframes(candidates, options_.culling, features_, map_)) {
    visits_.Remove(id);
    inertial_links_.Remove(id);
  }
  if (options_.max_keyframes > 0) Forget();
}

/// The newest keyframe is kept only for sessions that may still continue.
void Mapper::Forget() {
  const auto max_keyframes = static_cast<size_t>(options_.max_keyframes);
  if (map_.keyframes().size() <= max_keyframes) return;
  const auto last_of = [](const auto& session) { return session.second.keyframe_id; };
  std::vector<KeyframeId> newest;
  std::transform(sessions_.begin(), sessions_.end(), std::back_inserter(newest), last_of);
  std::sort(newest.begin(), newest.end(), std::greater<>());
  if (newest.size() > kRunningSessions) newest.resize(kRunningSessions);
  const auto is_kept = [&](const MapKeyframe& keyframe) {
    return IsAmongNewest(keyframe) && sessions_.at(keyframe.name.session).keyframe_id >= newest.back();
  };
  // Removes several at a time, because the selection costs time proportional to the map.
  for (const KeyframeId id : KeyframesToForget(map_, visits_, max_keyframes - max_keyframes / 50, is_kept)) {
    TakeOut(id, features_, map_);
    visits_.Remove(id);
    inertial_links_.Remove(id);
    // Republished keyframes are recognised by the number of the newest one, which therefore remains.
    for (auto& [session, last] : sessions_) {
      if (last.keyframe_id == id) last.keyframe_id = -1;
    }
  }
}

MapUpdate Mapper::TakeUpdate() {
  MapUpdate update = ChangedPart(map_, map_.TakeChanges());
  update.Follow(version_.number++);
  Sign(update);
  return update;
}

MapUpdate Mapper::Whole() const {
  MapUpdate update = WholeMap(map_);
  Sign(update);
  return update;
}

void Mapper::Sign(MapUpdate& update) const {
  // The first keyframe determines the camera.
  if (map_.keyframes().empty()) update.camera.reset();
  update.version = version_.number;
  const auto newest = sessions_.find(newest_session_);
  update.newest = {newest_session_, newest == sessions_.end() ? -1 : newest->second.session_keyframe_id};
  update.t_ns = newest_t_ns_;
  update.committed = committed_;
  update.localise_only = options_.localise_only;
  update.map_id = version_.map;
  update.adjustment = figures_;
}

// Localisation of a new keyframe in the map.

namespace {

// Inlier score of associations below which they do not correct the tracker's pose.
constexpr int kMinWeight = 20;
// Inlier score of associations above which a keyframe is relocated, however far.
constexpr int kRecognisedWeight = 40;
// Share of the image cells with expected landmarks that must show them before the first keyframe of a session is
// joined to them: at the same place at least 3 of 4 do, at repeated furniture less than half. loop_process joins the
// other sessions, once several keyframes agree.
constexpr double kRecognisedParts = 0.75;
// Squared Mahalanobis error of the tracker's motion above which the keyframe is in another part of the map.
constexpr double kElsewhere2 = 400.0;

// Number of features associated with different landmarks by two sources; lines count twice.
int Contradicting(const Association& a, const Association& b) {
  const auto differ = [](LandmarkId of_a, LandmarkId of_b) { return of_a >= 0 && of_b >= 0 && of_a != of_b ? 1 : 0; };
  return std::transform_reduce(a.points.begin(), a.points.end(), b.points.begin(), 0, std::plus<>(), differ) +
         2 * std::transform_reduce(a.lines.begin(), a.lines.end(), b.lines.begin(), 0, std::plus<>(), differ);
}

template <class Type>
void DropFarOf(const Map& map, std::span<const typename Type::Feature> features, const SE3& T_kf_w,
               const StereoCamera& camera, std::vector<LandmarkId>& association) {
  for (size_t i = 0; i < association.size(); ++i) {
    if (association[i] < 0) continue;
    const auto& landmark = *Type::Find(map, association[i]);
    if (!IsNear(landmark, features[i], T_kf_w, camera)) association[i] = -1;
  }
}

// Drops associations, not confirmed by a pose, whose landmark projects far from the feature.
void DropFar(const Map& map, const FeaturesView& features, const SE3& T_w_kf, const StereoCamera& camera,
             Association& association) {
  const SE3 T_kf_w = T_w_kf.Inverse();
  DropFarOf<PointType>(map, features.points, T_kf_w, camera, association.points);
  DropFarOf<LineType>(map, features.lines, T_kf_w, camera, association.lines);
}

// The keyframe that observes most of the landmarks; `association` must not be empty.
KeyframeId MostSeen(const Association& association, const Map& map) {
  std::map<KeyframeId, int> counts;
  CountKeyframes<PointType>(association.points, map, counts);
  CountKeyframes<LineType>(association.lines, map, counts);
  return MostCounted(counts, 1).front();
}

template <class Type>
void ForgetGone(const Map& map, std::vector<LandmarkId>& ids) {
  for (LandmarkId& id : ids) {
    if (id >= 0 && Type::Find(map, id) == nullptr) id = -1;
  }
}

}  // namespace

Matrix6d Mapper::Join(const Keyframe& keyframe, MapKeyframe& entry, Association& association) {
  const bool begins = entry.previous_id < 0 && !map_.keyframes().empty();
  if (begins && association.Weight() < kMinWeight) Recognise(keyframe, entry, association);
  // First with the tracker's associations, then with guided matching around the resulting pose.
  Place(keyframe, entry, association);
  MergeWithMap(keyframe, association, entry);
  const LocalMap local = LocalMapOf(association, entry.previous_id, map_, options_.insertion.local_keyframes);
  SearchByProjection(map_, local, entry.T_w_kf, keyframe.features, camera_, options_.localisation, association);
  return Refine(keyframe, entry, association).value_or(entry.relative_covariance);
}

std::optional<Matrix6d> Mapper::Refine(const Keyframe& keyframe, MapKeyframe& entry, Association& association) const {
  if (association.Weight() < kMinWeight) return std::nullopt;
  const auto pose =
      RefinePose(map_, keyframe.features, camera_, entry.T_w_kf, options_.localisation.motion, association);
  if (!pose) return std::nullopt;
  entry.T_w_kf = pose->T_w_kf;
  return pose->covariance;
}

// Refines the predicted pose, or searches everywhere if most landmarks associated by the tracker do not fit it.
void Mapper::Place(const Keyframe& keyframe, MapKeyframe& entry, Association& association) {
  const Association given = TrackerLandmarks::Given(keyframe, map_);
  if (Contradicting(given, association) >= kRecognisedWeight) {
    Association there = given;
    MapKeyframe unused = entry;
    const bool agrees = Refine(keyframe, unused, there) && 2 * there.Weight() >= given.Weight();
    if (!agrees && Relocate(keyframe, given, entry, association)) return;
  }
  const Association from_tracker = association;
  const bool agrees = Refine(keyframe, entry, association) && 2 * association.Weight() >= from_tracker.Weight();
  if (agrees || Relocate(keyframe, from_tracker, entry, association)) return;
  DropFar(map_, keyframe.features, entry.T_w_kf, camera_, association);
}

bool Mapper::Relocate(const Keyframe& keyframe, const Association& from_tracker, MapKeyframe& entry,
                      Association& association) {
  if (from_tracker.Weight() < kRecognisedWeight) return false;
  Association found = from_tracker;
  const auto pose = FindPose(map_, keyframe.features, camera_, options_.localisation.motion,
                             (from_tracker.Weight() + 1) / 2, found);
  if (!pose) return false;
  association = found;
  const MapKeyframe& seen = *map_.FindKeyframe(MostSeen(association, map_));
  entry.T_w_kf = pose->T_w_kf;
  entry.covariance = ComposeCovariance(seen.covariance, seen.T_w_kf.Inverse() * pose->T_w_kf, pose->covariance);
  return true;
}

// The keyframe observes landmarks of a part of the map that is not connected with its predecessor, so its pose differs
// from the tracker's motion: unless the tracker was lost, this connects the two parts, and the younger one is moved.
void Mapper::MergeWithMap(const Keyframe& keyframe, Association& association, MapKeyframe& entry) {
  if (entry.previous_id < 0 || keyframe.state == kRecovered || association.Weight() < kMinWeight) return;
  const SE3 T_w_predicted = map_.FindKeyframe(entry.previous_id)->T_w_kf * entry.T_prevkf_kf;
  const Vector6d error = (T_w_predicted.Inverse() * entry.T_w_kf).Log();
  if (SquaredMahalanobis<6>(error, entry.relative_covariance) < kElsewhere2) return;
  const MapGraph graph(map_);
  const std::set<KeyframeId> own = graph.Component(entry.previous_id, MapGraph::Edges::kAll);
  const KeyframeId seen_id = MostSeen(association, map_);
  if (own.contains(seen_id)) return;
  const std::set<KeyframeId> seen = graph.Component(seen_id, MapGraph::Edges::kAll);
  const bool own_moves = *own.begin() > *seen.begin();
  const SE3 T_w_fixed = own_moves ? entry.T_w_kf : T_w_predicted;
  const SE3 T_w_moving = own_moves ? T_w_predicted : entry.T_w_kf;
  std::map<KeyframeId, SE3> poses;
  for (const KeyframeId id : own_moves ? own : seen) {
    poses[id] = T_w_fixed * (T_w_moving.Inverse() * map_.FindKeyframe(id)->T_w_kf);
  }
  MoveKeyframes(poses, features_, camera_, map_);
  structural_version_ = version_.number + 1;
  entry.T_w_kf = T_w_fixed;
  // Drops associations with landmarks that lost their last possible observation by the move.
  ForgetGone<PointType>(map_, association.points);
  ForgetGone<LineType>(map_, association.lines);
}

void Mapper::Recognise(const Keyframe& keyframe, MapKeyframe& entry, Association& association) const {
  const MapKeyframe& newest = map_.keyframes().rbegin()->second;
  const LocalMap local = LocalMapOf({}, newest.id, map_, options_.insertion.local_keyframes);
  Association found = association;
  const auto pose =
      RecognisePose(map_, local, keyframe.features, camera_, options_.localisation, kRecognisedWeight, found);
  if (!pose) return;
  const MapKeyframe& seen = *map_.FindKeyframe(MostSeen(found, map_));
  SearchByProjection(map_, local, pose->T_w_kf, keyframe.features, camera_, options_.localisation, found);
  // Repeated furniture looks the same at each place, but its surroundings differ.
  const ExpectedLandmarks landmarks =
      CountExpected(map_, seen.id, pose->T_w_kf, CameraOf(keyframe.features, camera_), found);
  if (landmarks.cells_shown < kRecognisedParts * landmarks.cells) return;
  association = std::move(found);
  entry.T_w_kf = pose->T_w_kf;
  entry.covariance = ComposeCovariance(seen.covariance, seen.T_w_kf.Inverse() * pose->T_w_kf, pose->covariance);
}

}  // namespace plslam::mapping
