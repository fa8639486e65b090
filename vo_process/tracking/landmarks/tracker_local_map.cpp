// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/landmarks/tracker_local_map.h"

#include <algorithm>
#include <utility>

#include "core/localisation/local_map.h"
#include "core/map/landmark_types.h"

namespace plslam::vo {
namespace {

// Number of logged keyframes; the tracker drops its landmarks much earlier.
constexpr size_t kKeyframes = 60;
constexpr int kMinShared = 15;

const MapKeyframe* FindKeyframe(const Map& map, const KeyframeName& keyframe) {
  for (auto it = map.keyframes().rbegin(); it != map.keyframes().rend(); ++it) {
    if (it->second.name == keyframe) return &it->second;
  }
  return nullptr;
}

double FocalLength(const Map& map) { return map.camera() ? map.camera()->f_px : 0.0; }

}  // namespace

void KeyframeLog::Add(int64_t keyframe_id, std::vector<TrackId> point_ids, std::vector<TrackId> line_ids) {
  entries_.push_back({keyframe_id, std::move(point_ids), std::move(line_ids)});
  if (entries_.size() > kKeyframes) entries_.pop_front();
}

const KeyframeLog::Entry* KeyframeLog::Find(int64_t keyframe_id) const {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [keyframe_id](const Entry& entry) { return entry.keyframe_id == keyframe_id; });
  return found == entries_.end() ? nullptr : &*found;
}

template <class Type>
std::vector<Adopted<typename Type::Landmark>> KeyframeLog::Adopt(const Map& map, SessionId session,
                                                                 const std::vector<KeyframeId>& keyframes,
                                                                 std::vector<TrackId> Entry::*ids) const {
  std::vector<Adopted<typename Type::Landmark>> adopted;
  for (const LandmarkId landmark_id : SeenBy<Type>(keyframes, map)) {
    auto& entry = adopted.emplace_back();
    entry.landmark = Type::Find(map, landmark_id);
    for (const Observation& observation : entry.landmark->observations) {
      const MapKeyframe& keyframe = *map.FindKeyframe(observation.keyframe_id());
      if (keyframe.name.session != session) continue;
      const Entry* shown = Find(keyframe.name.number);
      const auto place = static_cast<size_t>(observation.feature);
      if (shown == nullptr || place >= (shown->*ids).size()) continue;
      const TrackId id = (shown->*ids)[place];
      const bool known = std::find(entry.tracker_ids.begin(), entry.tracker_ids.end(), id) != entry.tracker_ids.end();
      if (id >= 0 && !known) entry.tracker_ids.push_back(id);
    }
  }
  return adopted;
}

std::optional<TrackerLocalMap> KeyframeLog::LocalMapAround(const Map& map, const KeyframeName& keyframe,
                                                           int max_keyframes) const {
  const MapKeyframe* center = FindKeyframe(map, keyframe);
  if (center == nullptr) return std::nullopt;
  const std::vector<KeyframeId> keyframes = KeyframesAround(center->id, map, kMinShared, max_keyframes);
  TrackerLocalMap local_map;
  local_map.f_px = FocalLength(map);
  local_map.T_w_odom = center->T_w_kf * center->T_odom_kf.Inverse();
  local_map.points = Adopt<PointType>(map, keyframe.session, keyframes, &Entry::point_ids);
  local_map.lines = Adopt<LineType>(map, keyframe.session, keyframes, &Entry::line_ids);
  return local_map;
}

std::optional<TrackerLocalMap> LocalMapAt(const Map& map, KeyframeId keyframe_id, const SE3& T_w_odom,
                                          int max_keyframes) {
  if (map.FindKeyframe(keyframe_id) == nullptr) return std::nullopt;
  const std::vector<KeyframeId> keyframes = KeyframesAround(keyframe_id, map, kMinShared, max_keyframes);
  TrackerLocalMap local_map;
  local_map.f_px = FocalLength(map);
  local_map.T_w_odom = T_w_odom;
  for (const LandmarkId id : SeenBy<PointType>(keyframes, map)) local_map.points.push_back({map.FindPoint(id), {}});
  for (const LandmarkId id : SeenBy<LineType>(keyframes, map)) local_map.lines.push_back({map.FindLine(id), {}});
  return local_map;
}

}  // namespace plslam::vo
