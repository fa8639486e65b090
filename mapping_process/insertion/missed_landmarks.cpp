// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/missed_landmarks.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "core/map/landmark_types.h"

namespace plslam::mapping {
namespace {

// Largest angle between the optical axes of keyframes that are compared.
constexpr double kSameDirection_deg = 30.0;
// Landmarks shared with a keyframe of another session from which the two sessions are connected.
constexpr int kConnected = 15;
// Distance from the border of the image from which a landmark counts as in view.
constexpr double kInside_px = 20.0;
// Largest angle between the rays from two cameras to a landmark, and range of the ratio of their lengths, for the same
// view of it: from there it is neither behind something else nor too small.
constexpr double kSameView_deg = 10.0;
constexpr double kNearest = 0.8;
constexpr double kFarthest = 1.25;
// Share of a keyframe's landmarks that earlier visits must have observed, and least number of them relative to the
// earlier keyframe with most.
constexpr double kKnown = 0.3;
constexpr double kAsMany = 0.5;
// Visits in a row that have missed a landmark that is removed.
constexpr int64_t kVisits = 2;

struct Expected {
  std::vector<LandmarkId> missed;
  int found = 0;
};

bool IsInView(const Eigen::Vector3d& p_w, const SE3& T_c_w, const StereoCamera& camera) {
  const Eigen::Vector3d p_c = T_c_w * p_w;
  return p_c.z() > camera.MinDepth() && camera.InImage(camera.Project(p_c), kInside_px);
}

bool IsInView(const MapPoint& point, const SE3& T_c_w, const StereoCamera& camera) {
  return IsInView(point.p_w, T_c_w, camera);
}

bool IsInView(const MapLine& line, const SE3& T_c_w, const StereoCamera& camera) {
  return IsInView(line.segment_w.p, T_c_w, camera) && IsInView(line.segment_w.q, T_c_w, camera);
}

// Whether one of these keyframes observes the landmark from about the position `centre_w`.
template <class Landmark>
bool IsSeenFrom(const Eigen::Vector3d& centre_w, const Landmark& landmark, const std::vector<KeyframeId>& keyframes,
                const Map& map) {
  static const double kLeastCosine = std::cos(kSameView_deg * kRadPerDeg);
  const Eigen::Vector3d ray_w = Middle(landmark) - centre_w;
  return std::any_of(landmark.observations.begin(), landmark.observations.end(), [&](const Observation& observation) {
    if (!std::binary_search(keyframes.begin(), keyframes.end(), observation.keyframe_id())) return false;
    const Eigen::Vector3d other_w =
        Middle(landmark) - map.FindKeyframe(observation.keyframe_id())->T_w_kf.translation();
    const double ratio = ray_w.norm() / other_w.norm();
    return ratio > kNearest && ratio < kFarthest && ray_w.dot(other_w) > kLeastCosine * ray_w.norm() * other_w.norm();
  });
}

// Returns the keyframes of earlier visits that were near this one and looked in the same direction, ascending. Common
// landmarks are no criterion, because a place that has changed has none.
std::vector<KeyframeId> EarlierHere(const MapKeyframe& keyframe, const Visits& visits, const Map& map) {
  static const double kLeastCosine = std::cos(kSameDirection_deg * kRadPerDeg);
  std::set<SessionId> sessions{keyframe.name.session};
  for (const Map::Neighbour& neighbour : map.Neighbours(keyframe.id, kConnected)) {
    sessions.insert(map.FindKeyframe(neighbour.keyframe_id)->name.session);
  }
  const double near_m = visits.Near_m(keyframe);
  std::vector<KeyframeId> earlier;
  for (const auto& [id, other] : map.keyframes()) {
    if ((other.T_w_kf.translation() - keyframe.T_w_kf.translation()).norm() > near_m) continue;
    if (other.T_w_kf.R().col(2).dot(keyframe.T_w_kf.R().col(2)) < kLeastCosine) continue;
    if (sessions.contains(other.name.session) && visits.IsBefore(other, keyframe)) earlier.push_back(id);
  }
  return earlier;
}

// `earlier`: keyframes of earlier visits, ascending.
template <class Type>
Expected Compared(const MapKeyframe& keyframe, const std::vector<KeyframeId>& earlier, const StereoCamera& camera,
                  const Visits& visits, const Map& map) {
  const SE3 T_c_w = keyframe.T_w_kf.Inverse();
  Expected expected;
  for (const LandmarkId id : SeenBy<Type>(earlier, map)) {
    const typename Type::Landmark& landmark = *Type::Find(map, id);
    const KeyframeId newest_id = landmark.observations.back().keyframe_id();
    const bool found = newest_id == keyframe.id;
    if (!found && !visits.IsBefore(*map.FindKeyframe(newest_id), keyframe)) continue;
    if (!IsInView(landmark, T_c_w, camera)) continue;
    if (!IsSeenFrom(keyframe.T_w_kf.translation(), landmark, earlier, map)) continue;
    if (found) {
      ++expected.found;
    } else {
      expected.missed.push_back(id);
    }
  }
  return expected;
}

template <class Type>
int CountLandmarks(KeyframeId keyframe_id, const Map& map) {
  const std::vector<LandmarkId>& landmarks = Type::Of(map, keyframe_id);
  return static_cast<int>(std::count_if(landmarks.begin(), landmarks.end(), [](LandmarkId id) { return id >= 0; }));
}

int CountLandmarks(KeyframeId keyframe_id, const Map& map) {
  return CountLandmarks<PointType>(keyframe_id, map) + CountLandmarks<LineType>(keyframe_id, map);
}

// Whether a keyframe that found so many landmarks of earlier visits shows the place as well as they did.
bool IsComparable(KeyframeId keyframe_id, int found, const std::vector<KeyframeId>& earlier, const Map& map) {
  int most = 0;
  for (const KeyframeId id : earlier) most = std::max(most, CountLandmarks(id, map));
  const int own = CountLandmarks(keyframe_id, map);
  return own > 0 && found >= kKnown * own && own >= kAsMany * most;
}

}  // namespace

void MissedLandmarks::Compare(KeyframeId keyframe_id, const Visits& visits, const StereoCamera& camera, Map& map) {
  for (const LandmarkId id : PointType::Of(map, keyframe_id)) points_.erase(id);
  for (const LandmarkId id : LineType::Of(map, keyframe_id)) lines_.erase(id);
  const MapKeyframe& keyframe = *map.FindKeyframe(keyframe_id);
  const std::vector<KeyframeId> earlier = EarlierHere(keyframe, visits, map);
  if (earlier.empty()) return;
  const Expected points = Compared<PointType>(keyframe, earlier, camera, visits, map);
  const Expected lines = Compared<LineType>(keyframe, earlier, camera, visits, map);
  if (!IsComparable(keyframe_id, points.found + lines.found, earlier, map)) return;
  Update<PointType>(points.missed, keyframe, visits, points_, map);
  Update<LineType>(lines.missed, keyframe, visits, lines_, map);
}

template <class Type>
void MissedLandmarks::Update(const std::vector<LandmarkId>& missed, const MapKeyframe& keyframe, const Visits& visits,
                             Table& table, Map& map) {
  const Visits::Moment now = visits.MomentOf(keyframe);
  for (const LandmarkId id : missed) {
    Entry& entry = table[id];
    // A later search may have found it after all.
    if (Type::Find(map, id)->observations.back().keyframe_id() > entry.newest.keyframe_id) entry = {};
    const bool is_new = entry.visits == 0 || visits.IsBefore(entry.newest, visits.Near_m(keyframe), keyframe);
    if (is_new) ++entry.visits;
    if (is_new || entry.newest.session == keyframe.name.session) entry.newest = now;
    if (entry.visits < kVisits) continue;
    table.erase(id);
    Type::Remove(id, map);
  }
  // Only a table with many landmarks that were removed otherwise is larger than the map.
  if (table.size() <= 2 * Type::Landmarks(map).size()) return;
  std::erase_if(table, [&map](const auto& entry) { return Type::Find(map, entry.first) == nullptr; });
}

}  // namespace plslam::mapping
