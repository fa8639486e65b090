#include "core/map/map.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

namespace plslam {
namespace {

void SetLandmark(std::vector<int64_t>& of, int32_t feature, int64_t landmark_id) {
  const auto place = static_cast<size_t>(feature);
  if (of.size() <= place) of.resize(place + 1, -1);
  of[place] = landmark_id;
}

void CheckSights(const char* kind, int64_t id, const std::vector<Sight>& sights) {
  for (size_t i = 0; i < sights.size(); ++i) {
    const bool ascends = i == 0 || sights[i - 1].keyframe_id < sights[i].keyframe_id;
    if (ascends && sights[i].feature >= 0) continue;
    throw std::invalid_argument(std::string(kind) + " " + std::to_string(id) + ": sight " + std::to_string(i) +
                                " is of keyframe " + std::to_string(sights[i].keyframe_id) + ", feature " +
                                std::to_string(sights[i].feature) + ", and sights must ascend by keyframe");
  }
}

/// Keyframes of `a` that are not in `b` (`common` false), or are (true).
std::vector<int64_t> Keyframes(const std::vector<Sight>& a, const std::vector<Sight>& b, bool common) {
  std::vector<int64_t> ids;
  auto other = b.begin();
  for (const Sight& sight : a) {
    while (other != b.end() && other->keyframe_id < sight.keyframe_id) ++other;
    const bool is_common = other != b.end() && other->keyframe_id == sight.keyframe_id;
    if (is_common == common) ids.push_back(sight.keyframe_id);
  }
  return ids;
}

/// Sights of `a` that are not in `b`.
std::vector<Sight> Without(const std::vector<Sight>& a, const std::vector<Sight>& b) {
  std::vector<Sight> rest;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(rest),
                      [](const Sight& x, const Sight& y) {
                        return std::pair(x.keyframe_id, x.feature) < std::pair(y.keyframe_id, y.feature);
                      });
  return rest;
}

}  // namespace

bool MapChanges::empty() const {
  return keyframes.empty() && removed_keyframes.empty() && points.empty() && removed_points.empty() &&
         lines.empty() && removed_lines.empty() && loops.empty();
}

const MapKeyframe* Map::FindKeyframe(int64_t id) const { return keyframes_.Find(id); }
const MapPoint* Map::FindPoint(int64_t id) const { return points_.Find(id); }
const MapLine* Map::FindLine(int64_t id) const { return lines_.Find(id); }

MapTotals Map::Totals() const {
  return {static_cast<int64_t>(keyframes_.size()),
          static_cast<int64_t>(points_.size()),
          static_cast<int64_t>(lines_.size()),
          n_point_sights_,
          n_line_sights_,
          static_cast<int64_t>(loops_.size())};
}

void Map::Put(const MapKeyframe& keyframe) {
  const auto [place, added] = keyframes_.try_emplace(keyframe.id, keyframe);
  if (!added) {
    children_[place->parent_id].erase(keyframe.id);
    *place = keyframe;
  }
  children_[keyframe.parent_id].insert(keyframe.id);
  landmarks_of_.try_emplace(keyframe.id);
  shared_.try_emplace(keyframe.id);
  changes_.keyframes.insert(keyframe.id);
  changes_.removed_keyframes.erase(keyframe.id);
}

Map::Kind<MapPoint> Map::Points() {
  return {points_, &FeatureLandmarks::points, changes_.points, changes_.removed_points, n_point_sights_};
}

Map::Kind<MapLine> Map::Lines() {
  return {lines_, &FeatureLandmarks::lines, changes_.lines, changes_.removed_lines, n_line_sights_};
}

/// Replaces the sights of a landmark, and keeps the tables that follow from them.
template <class Landmark>
void Map::SetSights(Landmark& landmark, std::vector<Sight> sights, Kind<Landmark> kind) {
  const std::vector<Sight> old = std::exchange(landmark.sights, std::move(sights));
  const std::vector<Sight>& now = landmark.sights;
  kind.n_sights += static_cast<int64_t>(now.size()) - static_cast<int64_t>(old.size());
  const std::vector<int64_t> kept = Keyframes(old, now, true);
  CountShared(Keyframes(old, now, false), kept, -1);
  CountShared(Keyframes(now, old, false), kept, 1);
  for (const Sight& sight : Without(old, now)) {
    SetLandmark(landmarks_of_[sight.keyframe_id].*kind.of, sight.feature, -1);
  }
  for (const Sight& sight : Without(now, old)) {
    SetLandmark(landmarks_of_[sight.keyframe_id].*kind.of, sight.feature, landmark.id);
  }
}

template <class Landmark>
void Map::PutLandmark(Landmark landmark, Kind<Landmark> kind) {
  kind.removed.erase(landmark.id);
  kind.changed.insert(landmark.id);
  Landmark& stored = kind.landmarks[landmark.id];
  std::vector<Sight> sights = std::move(landmark.sights);
  std::erase_if(sights, [this](const Sight& sight) { return !keyframes_.contains(sight.keyframe_id); });
  landmark.sights = std::move(stored.sights);
  stored = std::move(landmark);
  if (stored.sights == sights) return;
  for (const Sight& sight : sights) {
    const std::vector<int64_t>& of_keyframe = landmarks_of_[sight.keyframe_id].*kind.of;
    const auto feature = static_cast<size_t>(sight.feature);
    const int64_t owner = feature < of_keyframe.size() ? of_keyframe[feature] : -1;
    if (owner < 0 || owner == stored.id) continue;
    Landmark& robbed = kind.landmarks.at(owner);
    std::vector<Sight> rest = robbed.sights;
    std::erase(rest, sight);
    SetSights(robbed, std::move(rest), kind);
    kind.changed.insert(owner);
  }
  SetSights(stored, std::move(sights), kind);
}

void Map::Put(MapPoint point) {
  CheckSights("point", point.id, point.sights);
  PutLandmark(std::move(point), Points());
}

void Map::Put(MapLine line) {
  CheckSights("line", line.id, line.sights);
  PutLandmark(std::move(line), Lines());
}

template <class Landmark>
void Map::RemoveLandmark(int64_t id, Kind<Landmark> kind) {
  Landmark* landmark = kind.landmarks.Find(id);
  if (landmark == nullptr) return;
  SetSights(*landmark, {}, kind);
  kind.landmarks.erase(id);
  kind.changed.erase(id);
  kind.removed.insert(id);
}

void Map::RemovePoint(int64_t id) { RemoveLandmark(id, Points()); }
void Map::RemoveLine(int64_t id) { RemoveLandmark(id, Lines()); }

template <class Landmark>
void Map::DropSightsOf(int64_t keyframe_id, Kind<Landmark> kind) {
  const std::vector<int64_t> seen = landmarks_of_[keyframe_id].*kind.of;
  for (const int64_t id : seen) {
    if (id < 0) continue;
    Landmark& landmark = kind.landmarks.at(id);
    std::vector<Sight> rest = landmark.sights;
    std::erase_if(rest, [keyframe_id](const Sight& sight) { return sight.keyframe_id == keyframe_id; });
    if (rest.empty()) {
      RemoveLandmark(id, kind);
    } else {
      SetSights(landmark, std::move(rest), kind);
      kind.changed.insert(id);
    }
  }
}

void Map::RemoveKeyframe(int64_t id) {
  const MapKeyframe* keyframe = FindKeyframe(id);
  if (keyframe == nullptr) return;
  const int64_t parent_id = keyframe->parent_id;
  for (const int64_t child_id : Children(id)) {
    MapKeyframe child = keyframes_.at(child_id);
    child.parent_id = parent_id;
    // An older neighbour keeps the tree a tree.
    for (const Neighbour& neighbour : Neighbours(child_id, kParent)) {
      if (neighbour.keyframe_id >= child_id || neighbour.keyframe_id == id) continue;
      child.parent_id = neighbour.keyframe_id;
      break;
    }
    Put(child);
  }
  DropSightsOf(id, Points());
  DropSightsOf(id, Lines());
  children_[parent_id].erase(id);
  children_.erase(id);
  shared_.erase(id);
  landmarks_of_.erase(id);
  keyframes_.erase(id);
  changes_.keyframes.erase(id);
  changes_.removed_keyframes.insert(id);
}

void Map::Add(const LoopEdge& loop) {
  loops_.push_back(loop);
  changes_.loops.push_back(loop);
}

void Map::Clear() { *this = Map(); }

void Map::SetPose(int64_t keyframe_id, const SE3& T_w_kf, const Matrix6d& covariance) {
  MapKeyframe& keyframe = keyframes_.at(keyframe_id);
  keyframe.T_w_kf = T_w_kf;
  keyframe.covariance = covariance;
  changes_.keyframes.insert(keyframe_id);
}

void Map::SetPosition(int64_t point_id, const Eigen::Vector3d& p_w, const Eigen::Matrix3d& covariance) {
  MapPoint& point = points_.at(point_id);
  point.p_w = p_w;
  point.covariance = covariance;
  changes_.points.insert(point_id);
}

void Map::SetSegment(int64_t line_id, const Segment3& segment_w, const Eigen::Matrix3d& covariance_p,
                     const Eigen::Matrix3d& covariance_q) {
  MapLine& line = lines_.at(line_id);
  line.segment_w = segment_w;
  line.covariance_p = covariance_p;
  line.covariance_q = covariance_q;
  changes_.lines.insert(line_id);
}

/// Counts a landmark of `changed` and `kept` keyframes for the pairs in which one is of the changed.
void Map::CountShared(const std::vector<int64_t>& changed, const std::vector<int64_t>& kept, int sign) {
  const auto count_one_way = [this, sign](int64_t from, int64_t to) { shared_[from].Add(to, sign); };
  for (size_t i = 0; i < changed.size(); ++i) {
    const auto count = [&](int64_t other) {
      count_one_way(changed[i], other);
      count_one_way(other, changed[i]);
    };
    std::for_each(kept.begin(), kept.end(), count);
    std::for_each(changed.begin(), changed.begin() + static_cast<std::ptrdiff_t>(i), count);
  }
}

const Map::FeatureLandmarks& Map::LandmarksOf(int64_t keyframe_id) const { return landmarks_of_.at(keyframe_id); }

int Map::Shared(int64_t a, int64_t b) const {
  const SharedCounts* row = shared_.Find(a);
  return row == nullptr ? 0 : row->Of(b);
}

std::vector<Map::Neighbour> Map::Neighbours(int64_t keyframe_id, int min_shared) const {
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

std::vector<int64_t> Map::Children(int64_t keyframe_id) const {
  const std::set<int64_t>* children = children_.Find(keyframe_id);
  if (children == nullptr) return {};
  return {children->begin(), children->end()};
}

MapChanges Map::TakeChanges() { return std::exchange(changes_, {}); }

}  // namespace plslam
