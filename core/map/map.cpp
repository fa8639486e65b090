// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/map.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace plslam {
namespace {

void SetLandmark(std::vector<LandmarkId>& of, int32_t feature, LandmarkId landmark_id) {
  const auto place = static_cast<size_t>(feature);
  if (of.size() <= place) of.resize(place + 1, -1);
  of[place] = landmark_id;
}

void CheckObservations(const char* kind, LandmarkId id, const std::vector<Observation>& observations) {
  for (size_t i = 0; i < observations.size(); ++i) {
    const bool ascends = i == 0 || observations[i - 1].keyframe_id() < observations[i].keyframe_id();
    if (ascends && observations[i].feature >= 0) continue;
    throw std::invalid_argument(fmt::format(
        "{} {}: observation {} is of keyframe {}, feature {}, but observations must be in ascending order of "
        "keyframes",
        kind, id, i, observations[i].keyframe_id(), int32_t{observations[i].feature}));
  }
}

/// Calls `visit` with each observation of `a` and that of the same keyframe in `b`, nullptr if there is none.
template <class Visit>
void ForEachBeside(const std::vector<Observation>& a, const std::vector<Observation>& b, const Visit& visit) {
  auto other = b.begin();
  for (const Observation& observation : a) {
    while (other != b.end() && other->keyframe_id() < observation.keyframe_id()) ++other;
    const bool has_other = other != b.end() && other->keyframe_id() == observation.keyframe_id();
    visit(observation, has_other ? &*other : nullptr);
  }
}

template <class AnId>
std::vector<AnId> SortedOnce(std::vector<AnId> ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

template <class AnId>
bool Has(const std::vector<AnId>& ascending, AnId id) {
  return std::binary_search(ascending.begin(), ascending.end(), id);
}

/// Compares bit for bit, except for the sign of the quaternion, which messages do not keep.
bool IsSame(const SE3& a, const SE3& b) {
  const Eigen::Vector4d p = a.rotation().coeffs();
  const Eigen::Vector4d q = b.rotation().coeffs();
  return a.translation() == b.translation() && (p == q || p == -q);
}

/// Splits touched ids into those in `values`, which have changed, and the others, which were removed.
template <class AnId, class Value>
void CollectChanges(std::vector<AnId> touched, const IdMap<AnId, Value>& values, std::vector<AnId>& changed,
                    std::vector<AnId>& removed) {
  for (const AnId id : SortedOnce(std::move(touched))) (values.contains(id) ? changed : removed).push_back(id);
}

}  // namespace

bool MapChanges::empty() const {
  return moved_keyframes.empty() && keyframes.empty() && removed_keyframes.empty() && points.empty() &&
         removed_points.empty() && lines.empty() && removed_lines.empty() && loops.empty();
}

const MapKeyframe* Map::FindKeyframe(KeyframeId id) const { return keyframes_.Find(id); }
const MapPoint* Map::FindPoint(LandmarkId id) const { return points_.Find(id); }
const MapLine* Map::FindLine(LandmarkId id) const { return lines_.Find(id); }

MapTotals Map::Totals() const {
  return {static_cast<int64_t>(keyframes_.size()),
          static_cast<int64_t>(points_.size()),
          static_cast<int64_t>(lines_.size()),
          n_point_observations_,
          n_line_observations_,
          static_cast<int64_t>(loops_.size())};
}

void Map::Put(const MapKeyframe& keyframe) {
  const auto [place, added] = keyframes_.try_emplace(keyframe.id, keyframe);
  if (!added) {
    children_[place->parent_id].erase(keyframe.id);
    *place = keyframe;
  }
  // A mapper that continues from an older state inserts keyframes again.
  if (removed_) removed_->Forget(keyframe.id);
  children_[keyframe.parent_id].insert(keyframe.id);
  landmarks_of_.try_emplace(keyframe.id);
  shared_.try_emplace(keyframe.id);
  touched_.keyframes.push_back(keyframe.id);
}

Map::Kind<MapPoint> Map::Points() {
  return {points_, &FeatureLandmarks::points, touched_.points, n_point_observations_};
}

Map::Kind<MapLine> Map::Lines() { return {lines_, &FeatureLandmarks::lines, touched_.lines, n_line_observations_}; }

/// Replaces the observations of a landmark.
template <class Landmark>
void Map::SetObservations(Landmark& landmark, std::vector<Observation> observations, Kind<Landmark> kind) {
  const std::vector<Observation> old = std::exchange(landmark.observations, std::move(observations));
  FollowObservations(old, landmark, kind);
}

/// Updates the tables derived from the observations of a landmark, which were `old`.
template <class Landmark>
void Map::FollowObservations(const std::vector<Observation>& old, const Landmark& landmark, Kind<Landmark> kind) {
  const std::vector<Observation>& now = landmark.observations;
  kind.n_observations += static_cast<int64_t>(now.size()) - static_cast<int64_t>(old.size());
  CountShared(old, now, -1);
  CountShared(now, old, 1);
  const auto set_where_new = [&](const std::vector<Observation>& observations, const std::vector<Observation>& others,
                                 LandmarkId id) {
    ForEachBeside(observations, others, [&](const Observation& observation, const Observation* other) {
      if (other != nullptr && other->feature == observation.feature) return;
      SetLandmark(landmarks_of_[observation.keyframe_id()].*kind.of, observation.feature, id);
    });
  };
  set_where_new(old, now, -1);
  set_where_new(now, old, landmark.id);
}

template <class Landmark>
void Map::PutLandmark(const Landmark& landmark, Kind<Landmark> kind) {
  const auto is_of_keyframe = [this](const Observation& observation) {
    return keyframes_.contains(observation.keyframe_id());
  };
  if (!std::all_of(landmark.observations.begin(), landmark.observations.end(), is_of_keyframe)) {
    Landmark rest = landmark;
    std::erase_if(rest.observations, std::not_fn(is_of_keyframe));
    return PutLandmark(rest, kind);
  }
  kind.touched.push_back(landmark.id);
  Landmark& stored = kind.landmarks[landmark.id];
  if (stored.observations == landmark.observations) {
    stored = landmark;
    return;
  }
  for (const Observation& observation : landmark.observations) {
    const std::vector<LandmarkId>& of_keyframe = landmarks_of_[observation.keyframe_id()].*kind.of;
    const auto feature = static_cast<size_t>(observation.feature);
    const LandmarkId owner = feature < of_keyframe.size() ? of_keyframe[feature] : -1;
    if (owner < 0 || owner == landmark.id) continue;
    Landmark& robbed = kind.landmarks.at(owner);
    std::vector<Observation> rest = robbed.observations;
    std::erase(rest, observation);
    SetObservations(robbed, std::move(rest), kind);
    kind.touched.push_back(owner);
  }
  const std::vector<Observation> old = std::exchange(stored.observations, {});
  stored = landmark;
  FollowObservations(old, stored, kind);
}

void Map::Put(const MapPoint& point) {
  CheckObservations("point", point.id, point.observations);
  PutLandmark(point, Points());
}

void Map::Put(const MapLine& line) {
  CheckObservations("line", line.id, line.observations);
  PutLandmark(line, Lines());
}

template <class Landmark>
void Map::RemoveLandmark(LandmarkId id, Kind<Landmark> kind) {
  Landmark* landmark = kind.landmarks.Find(id);
  if (landmark == nullptr) return;
  SetObservations(*landmark, {}, kind);
  kind.landmarks.erase(id);
  kind.touched.push_back(id);
}

void Map::RemovePoint(LandmarkId id) { RemoveLandmark(id, Points()); }
void Map::RemoveLine(LandmarkId id) { RemoveLandmark(id, Lines()); }

template <class Landmark>
void Map::DropObservationsOf(KeyframeId keyframe_id, Kind<Landmark> kind) {
  const std::vector<LandmarkId> seen = landmarks_of_[keyframe_id].*kind.of;
  for (const LandmarkId id : seen) {
    if (id < 0) continue;
    Landmark& landmark = kind.landmarks.at(id);
    std::vector<Observation> rest = landmark.observations;
    std::erase_if(rest,
                  [keyframe_id](const Observation& observation) { return observation.keyframe_id() == keyframe_id; });
    if (rest.empty()) {
      RemoveLandmark(id, kind);
    } else {
      SetObservations(landmark, std::move(rest), kind);
      kind.touched.push_back(id);
    }
  }
}

void Map::RemoveKeyframe(KeyframeId id) {
  const MapKeyframe* keyframe = FindKeyframe(id);
  if (keyframe == nullptr) return;
  if (removed_) removed_->Add(*keyframe, CarrierOf(*keyframe));
  const KeyframeId parent_id = keyframe->parent_id;
  for (const KeyframeId child_id : Children(id)) {
    MapKeyframe child = keyframes_.at(child_id);
    child.parent_id = parent_id;
    // Choosing an older neighbour avoids cycles in the spanning tree.
    for (const Neighbour& neighbour : Neighbours(child_id, kParent)) {
      if (neighbour.keyframe_id >= child_id || neighbour.keyframe_id == id) continue;
      child.parent_id = neighbour.keyframe_id;
      break;
    }
    Put(child);
  }
  DropObservationsOf(id, Points());
  DropObservationsOf(id, Lines());
  const auto ends_here = [id](const LoopEdge& loop) { return loop.EndsAt(id); };
  std::erase_if(loops_, ends_here);
  std::erase_if(touched_.loops, ends_here);
  children_[parent_id].erase(id);
  children_.erase(id);
  shared_.erase(id);
  landmarks_of_.erase(id);
  keyframes_.erase(id);
  touched_.keyframes.push_back(id);
}

KeyframeId Map::CarrierOf(const MapKeyframe& keyframe) const {
  const std::vector<Neighbour> neighbours = Neighbours(keyframe.id, 1);
  if (!neighbours.empty()) {
    // Later adjustments move an old keyframe less than a new one, so what it carries stays where it was.
    KeyframeId oldest_id = neighbours.front().keyframe_id;
    for (const Neighbour& n : neighbours) {
      if (2 * n.shared >= neighbours.front().shared) oldest_id = std::min(oldest_id, n.keyframe_id);
    }
    return oldest_id;
  }
  if (FindKeyframe(keyframe.parent_id) != nullptr) return keyframe.parent_id;
  if (FindKeyframe(keyframe.previous_id) != nullptr) return keyframe.previous_id;
  KeyframeId nearest_id = -1;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const auto& [id, other] : keyframes_) {
    const double distance_m = (other.T_w_kf.translation() - keyframe.T_w_kf.translation()).norm();
    if (id == keyframe.id || distance_m >= nearest_m) continue;
    nearest_id = id;
    nearest_m = distance_m;
  }
  return nearest_id;
}

std::vector<RemovedKeyframe> Map::RemovedKeyframes() const {
  return removed_ ? removed_->Keyframes() : std::vector<RemovedKeyframe>();
}

void Map::BeginVersion(int64_t version) {
  if (removed_) removed_->BeginVersion(version);
}

void Map::Add(const LoopEdge& loop) {
  if (!keyframes_.contains(loop.old_keyframe_id) || !keyframes_.contains(loop.keyframe_id)) return;
  const auto place = std::ranges::upper_bound(loops_, loop.keyframe_id, {}, &LoopEdge::keyframe_id);
  loops_.insert(place, loop);
  touched_.loops.push_back(loop);
}

void Map::Clear() { *this = Map(); }

void Map::ContinueAs(Map next, int64_t version) {
  if (removed_) {
    if (version < removed_->version()) {
      removed_->ReturnTo(version, next.keyframes_);
    } else {
      removed_->BeginVersion(version);
      std::vector<KeyframeId> gone;
      std::map<KeyframeId, SE3> T_new_old;
      for (const auto& [id, keyframe] : keyframes_) {
        if (const MapKeyframe* const same = next.FindKeyframe(id)) {
          if (!IsSame(same->T_w_kf, keyframe.T_w_kf)) T_new_old[id] = same->T_w_kf * keyframe.T_w_kf.Inverse();
        } else {
          gone.push_back(id);
        }
      }
      for (const KeyframeId id : gone) RemoveKeyframe(id);
      removed_->Move(T_new_old);
    }
    for (const auto& [id, keyframe] : next.keyframes_) removed_->Forget(id);
  }
  next.removed_ = std::move(removed_);
  *this = std::move(next);
}

void Map::SetPose(KeyframeId keyframe_id, const SE3& T_w_kf, const Matrix6d& covariance) {
  MapKeyframe& keyframe = keyframes_.at(keyframe_id);
  keyframe.T_w_kf = T_w_kf;
  keyframe.covariance = covariance;
  touched_.keyframes.push_back(keyframe_id);
}

void Map::SetPosition(LandmarkId point_id, const Eigen::Vector3d& p_w, const Eigen::Matrix3d& covariance) {
  MapPoint& point = points_.at(point_id);
  point.p_w = p_w;
  point.covariance = covariance;
  touched_.points.push_back(point_id);
}

void Map::SetSegment(LandmarkId line_id, const Segment3& segment_w, const Eigen::Matrix3d& covariance_p,
                     const Eigen::Matrix3d& covariance_q) {
  MapLine& line = lines_.at(line_id);
  line.segment_w = segment_w;
  line.covariance_p = covariance_p;
  line.covariance_q = covariance_q;
  touched_.lines.push_back(line_id);
}

template <class Landmark>
void Map::MoveLandmarks(const Moves& moves, Kind<Landmark> kind) {
  const std::vector<LandmarkId> changed_before = SortedOnce(kind.touched);
  for (const auto& [id, unmoved] : kind.landmarks) {
    const KeyframeId anchor = AnchorOf(unmoved.observations);
    const auto move = moves.T_new_old.find(anchor);
    if (move == moves.T_new_old.end()) continue;
    Landmark& landmark = kind.landmarks.at(id);
    MoveRigidly(move->second, landmark);
    if (moves.changed_anchors.contains(anchor) || Has(changed_before, id)) kind.touched.push_back(id);
  }
}

void Map::Move(const std::map<KeyframeId, SE3>& T_w_kf) {
  const std::vector<KeyframeId> changed_before = SortedOnce(touched_.keyframes);
  Moves moves;
  for (const auto& [id, pose] : T_w_kf) {
    MapKeyframe* keyframe = keyframes_.Find(id);
    if (keyframe == nullptr || IsSame(pose, keyframe->T_w_kf)) continue;
    moves.T_new_old[id] = pose * keyframe->T_w_kf.Inverse();
    keyframe->T_w_kf = pose;
    const bool first = moved_.insert_or_assign(id, pose).second;
    if (first && !Has(changed_before, id)) continue;
    moves.changed_anchors.insert(id);
    touched_.keyframes.push_back(id);
  }
  if (moves.T_new_old.empty()) return;
  if (removed_) removed_->Move(moves.T_new_old);
  MoveLandmarks(moves, Points());
  MoveLandmarks(moves, Lines());
}

void Map::SetCovariances(const std::map<KeyframeId, Matrix6d>& covariances) {
  const std::vector<KeyframeId> changed_before = SortedOnce(touched_.keyframes);
  for (const auto& [id, covariance] : covariances) {
    MapKeyframe& keyframe = keyframes_.at(id);
    keyframe.covariance = covariance;
    if (!Has(changed_before, id)) moved_.try_emplace(id, keyframe.T_w_kf);
  }
}

/// Counts a landmark with these observations for the pairs of keyframes of which at least one is not among those of
/// `others`.
void Map::CountShared(const std::vector<Observation>& observations, const std::vector<Observation>& others,
                      int sign) {
  ForEachBeside(observations, others, [&](const Observation& observation, const Observation* same) {
    if (same != nullptr) return;
    const KeyframeId a = observation.keyframe_id();
    ForEachBeside(observations, others, [&](const Observation& partner, const Observation* common) {
      const KeyframeId b = partner.keyframe_id();
      // A pair of which neither is in `others` occurs twice: count it once.
      if (b == a || (common == nullptr && b > a)) return;
      shared_[a].Add(b, sign);
      shared_[b].Add(a, sign);
    });
  });
}

const Map::FeatureLandmarks& Map::LandmarksOf(KeyframeId keyframe_id) const { return landmarks_of_.at(keyframe_id); }

int Map::Shared(KeyframeId a, KeyframeId b) const {
  const SharedCounts* row = shared_.Find(a);
  return row == nullptr ? 0 : row->Of(b);
}

std::vector<Map::Neighbour> Map::Neighbours(KeyframeId keyframe_id, int min_shared) const {
  std::vector<Neighbour> neighbours;
  const SharedCounts* row = shared_.Find(keyframe_id);
  if (row == nullptr) return neighbours;
  for (const auto& [other, shared] : *row) {
    if (shared >= min_shared) neighbours.push_back({other, shared});
  }
  std::stable_sort(neighbours.begin(), neighbours.end(),
                   [](const Neighbour& a, const Neighbour& b) { return a.shared > b.shared; });
  return neighbours;
}

std::vector<KeyframeId> Map::Children(KeyframeId keyframe_id) const {
  const std::set<KeyframeId>* children = children_.Find(keyframe_id);
  if (children == nullptr) return {};
  return {children->begin(), children->end()};
}

MapChanges Map::TakeChanges() {
  MapChanges changes;
  for (const auto& [id, T_w_kf] : moved_) {
    const MapKeyframe* keyframe = FindKeyframe(id);
    changes.moved_keyframes.push_back({id, T_w_kf, keyframe == nullptr ? Matrix6d::Zero() : keyframe->covariance});
  }
  CollectChanges(std::move(touched_.keyframes), keyframes_, changes.keyframes, changes.removed_keyframes);
  CollectChanges(std::move(touched_.points), points_, changes.points, changes.removed_points);
  CollectChanges(std::move(touched_.lines), lines_, changes.lines, changes.removed_lines);
  changes.loops = std::move(touched_.loops);
  ForgetChanges();
  return changes;
}

void Map::ForgetChanges() {
  moved_.clear();
  touched_.keyframes.clear();
  touched_.points.clear();
  touched_.lines.clear();
  touched_.loops.clear();
}

}  // namespace plslam
