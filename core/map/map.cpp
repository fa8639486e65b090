#include "core/map/map.h"

#include <algorithm>
#include <utility>

namespace plslam {
namespace {

template <class Value>
const Value* Find(const std::map<int64_t, Value>& values, int64_t id) {
  const auto found = values.find(id);
  return found == values.end() ? nullptr : &found->second;
}

void SetLandmark(std::vector<int64_t>& of, int32_t feature, int64_t landmark_id) {
  const auto place = static_cast<size_t>(feature);
  if (of.size() <= place) of.resize(place + 1, -1);
  of[place] = landmark_id;
}

bool SameKeyframes(const std::vector<Sight>& a, const std::vector<Sight>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Sight& x, const Sight& y) { return x.keyframe_id == y.keyframe_id; });
}

}  // namespace

bool MapChanges::empty() const {
  return keyframes.empty() && removed_keyframes.empty() && points.empty() && removed_points.empty() &&
         lines.empty() && removed_lines.empty();
}

const MapKeyframe* Map::FindKeyframe(int64_t id) const { return Find(keyframes_, id); }
const MapPoint* Map::FindPoint(int64_t id) const { return Find(points_, id); }
const MapLine* Map::FindLine(int64_t id) const { return Find(lines_, id); }

void Map::Put(const MapKeyframe& keyframe) {
  const auto [place, added] = keyframes_.try_emplace(keyframe.id, keyframe);
  if (!added) {
    children_[place->second.parent_id].erase(keyframe.id);
    place->second = keyframe;
  }
  children_[keyframe.parent_id].insert(keyframe.id);
  landmarks_of_.try_emplace(keyframe.id);
  shared_.try_emplace(keyframe.id);
  changes_.keyframes.insert(keyframe.id);
  changes_.removed_keyframes.erase(keyframe.id);
}

template <class Landmark>
void Map::PutLandmark(const Landmark& landmark, std::map<int64_t, Landmark>& landmarks,
                      std::vector<int64_t> FeatureLandmarks::*of, std::set<int64_t>& changed) {
  const auto [place, added] = landmarks.try_emplace(landmark.id);
  Landmark& stored = place->second;
  const std::vector<Sight> old = std::move(stored.sights);
  stored = landmark;
  std::erase_if(stored.sights, [this](const Sight& sight) { return !keyframes_.contains(sight.keyframe_id); });
  changed.insert(landmark.id);
  if (old == stored.sights) return;
  for (const Sight& sight : old) SetLandmark(landmarks_of_[sight.keyframe_id].*of, sight.feature, -1);
  const bool same_keyframes = SameKeyframes(old, stored.sights);
  if (!same_keyframes) CountShared(old, -1);
  for (const Sight& sight : stored.sights) {
    std::vector<int64_t>& of_keyframe = landmarks_of_[sight.keyframe_id].*of;
    const auto feature = static_cast<size_t>(sight.feature);
    const int64_t owner = feature < of_keyframe.size() ? of_keyframe[feature] : -1;
    if (owner >= 0 && owner != landmark.id) {
      Landmark& robbed = landmarks.at(owner);
      CountShared(robbed.sights, -1);
      std::erase(robbed.sights, sight);
      CountShared(robbed.sights, 1);
      changed.insert(owner);
    }
    SetLandmark(of_keyframe, sight.feature, landmark.id);
  }
  if (!same_keyframes) CountShared(stored.sights, 1);
}

void Map::Put(const MapPoint& point) {
  changes_.removed_points.erase(point.id);
  PutLandmark(point, points_, &FeatureLandmarks::points, changes_.points);
}

void Map::Put(const MapLine& line) {
  changes_.removed_lines.erase(line.id);
  PutLandmark(line, lines_, &FeatureLandmarks::lines, changes_.lines);
}

template <class Landmark>
void Map::RemoveLandmark(int64_t id, std::map<int64_t, Landmark>& landmarks,
                         std::vector<int64_t> FeatureLandmarks::*of, std::set<int64_t>& changed,
                         std::set<int64_t>& removed) {
  const auto found = landmarks.find(id);
  if (found == landmarks.end()) return;
  for (const Sight& sight : found->second.sights) SetLandmark(landmarks_of_[sight.keyframe_id].*of, sight.feature, -1);
  CountShared(found->second.sights, -1);
  landmarks.erase(found);
  changed.erase(id);
  removed.insert(id);
}

void Map::RemovePoint(int64_t id) {
  RemoveLandmark(id, points_, &FeatureLandmarks::points, changes_.points, changes_.removed_points);
}

void Map::RemoveLine(int64_t id) {
  RemoveLandmark(id, lines_, &FeatureLandmarks::lines, changes_.lines, changes_.removed_lines);
}

template <class Landmark>
void Map::DropSights(int64_t keyframe_id, std::map<int64_t, Landmark>& landmarks,
                     std::vector<int64_t> FeatureLandmarks::*of, std::set<int64_t>& changed,
                     std::set<int64_t>& removed) {
  const std::vector<int64_t> seen = landmarks_of_[keyframe_id].*of;
  for (const int64_t id : seen) {
    if (id < 0) continue;
    Landmark landmark = landmarks.at(id);
    std::erase_if(landmark.sights, [keyframe_id](const Sight& sight) { return sight.keyframe_id == keyframe_id; });
    if (landmark.sights.empty()) {
      RemoveLandmark(id, landmarks, of, changed, removed);
    } else {
      PutLandmark(landmark, landmarks, of, changed);
    }
  }
}

void Map::RemoveKeyframe(int64_t id) {
  const auto found = keyframes_.find(id);
  if (found == keyframes_.end()) return;
  const int64_t parent_id = found->second.parent_id;
  for (const int64_t child_id : Children(id)) {
    MapKeyframe child = keyframes_.at(child_id);
    child.parent_id = parent_id;
    // An older neighbour keeps the tree a tree.
    for (const Neighbour& neighbour : Neighbours(child_id, 1)) {
      if (neighbour.keyframe_id >= child_id || neighbour.keyframe_id == id) continue;
      child.parent_id = neighbour.keyframe_id;
      break;
    }
    Put(child);
  }
  DropSights(id, points_, &FeatureLandmarks::points, changes_.points, changes_.removed_points);
  DropSights(id, lines_, &FeatureLandmarks::lines, changes_.lines, changes_.removed_lines);
  children_[parent_id].erase(id);
  children_.erase(id);
  for (const auto& [other, count] : shared_[id]) shared_[other].erase(id);
  shared_.erase(id);
  landmarks_of_.erase(id);
  keyframes_.erase(found);
  changes_.keyframes.erase(id);
  changes_.removed_keyframes.insert(id);
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

void Map::CountShared(const std::vector<Sight>& sights, int sign) {
  for (size_t i = 0; i < sights.size(); ++i) {
    for (size_t j = 0; j < sights.size(); ++j) {
      if (i == j) continue;
      std::map<int64_t, int>& row = shared_[sights[i].keyframe_id];
      const int count = row[sights[j].keyframe_id] += sign;
      if (count == 0) row.erase(sights[j].keyframe_id);
    }
  }
}

const Map::FeatureLandmarks& Map::LandmarksOf(int64_t keyframe_id) const { return landmarks_of_.at(keyframe_id); }

int Map::Shared(int64_t a, int64_t b) const {
  const auto row = shared_.find(a);
  if (row == shared_.end()) return 0;
  const auto count = row->second.find(b);
  return count == row->second.end() ? 0 : count->second;
}

std::vector<Map::Neighbour> Map::Neighbours(int64_t keyframe_id, int min_shared) const {
  std::vector<Neighbour> neighbours;
  const auto row = shared_.find(keyframe_id);
  if (row == shared_.end()) return neighbours;
  for (const auto& [other, shared] : row->second) {
    if (shared >= min_shared) neighbours.push_back({other, shared});
  }
  std::stable_sort(neighbours.begin(), neighbours.end(),
                   [](const Neighbour& a, const Neighbour& b) { return a.shared > b.shared; });
  return neighbours;
}

std::vector<int64_t> Map::Children(int64_t keyframe_id) const {
  const auto found = children_.find(keyframe_id);
  if (found == children_.end()) return {};
  return {found->second.begin(), found->second.end()};
}

MapChanges Map::TakeChanges() { return std::exchange(changes_, {}); }

}  // namespace plslam
