#include "vo_process/tracking/map_patch.h"

#include <algorithm>
#include <utility>

#include "core/localisation/local_map.h"
#include "core/map/landmark_kinds.h"

namespace plslam {
namespace {

// The tracker drops its landmarks long before so many keyframes have passed.
constexpr size_t kKeyframes = 60;
constexpr int kMinShared = 15;

const MapKeyframe* FindKeyframe(const Map& map, int64_t session, int64_t keyframe_id) {
  for (auto it = map.keyframes().rbegin(); it != map.keyframes().rend(); ++it) {
    if (it->second.session == session && it->second.session_keyframe_id == keyframe_id) return &it->second;
  }
  return nullptr;
}

}  // namespace

void KeyframeLog::Add(int64_t keyframe_id, std::vector<int64_t> point_ids, std::vector<int64_t> line_ids) {
  entries_.push_back({keyframe_id, std::move(point_ids), std::move(line_ids)});
  if (entries_.size() > kKeyframes) entries_.pop_front();
}

const KeyframeLog::Entry* KeyframeLog::Find(int64_t keyframe_id) const {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [keyframe_id](const Entry& entry) { return entry.keyframe_id == keyframe_id; });
  return found == entries_.end() ? nullptr : &*found;
}

template <class Kind>
std::vector<Adopted<typename Kind::Landmark>> KeyframeLog::Adopt(const Map& map, int64_t session,
                                                                 const std::vector<int64_t>& keyframes,
                                                                 std::vector<int64_t> Entry::*ids) const {
  std::vector<Adopted<typename Kind::Landmark>> adopted;
  for (const int64_t landmark_id : SeenBy<Kind>(keyframes, map)) {
    auto& entry = adopted.emplace_back();
    entry.landmark = Kind::Find(map, landmark_id);
    for (const Sight& sight : entry.landmark->sights) {
      const MapKeyframe& keyframe = *map.FindKeyframe(sight.keyframe_id);
      if (keyframe.session != session) continue;
      const Entry* shown = Find(keyframe.session_keyframe_id);
      const auto place = static_cast<size_t>(sight.feature);
      if (shown == nullptr || place >= (shown->*ids).size()) continue;
      const int64_t id = (shown->*ids)[place];
      const bool known = std::find(entry.tracker_ids.begin(), entry.tracker_ids.end(), id) != entry.tracker_ids.end();
      if (id >= 0 && !known) entry.tracker_ids.push_back(id);
    }
  }
  return adopted;
}

std::optional<MapPatch> KeyframeLog::PatchAround(const Map& map, int64_t session, int64_t keyframe_id,
                                                 int max_keyframes) const {
  const MapKeyframe* center = FindKeyframe(map, session, keyframe_id);
  if (center == nullptr) return std::nullopt;
  const std::vector<int64_t> keyframes = KeyframesAround(center->id, map, kMinShared, max_keyframes);
  MapPatch patch;
  patch.T_w_odom = center->T_w_kf * center->T_odom_kf.Inverse();
  patch.points = Adopt<PointKind>(map, session, keyframes, &Entry::point_ids);
  patch.lines = Adopt<LineKind>(map, session, keyframes, &Entry::line_ids);
  return patch;
}

std::optional<MapPatch> PatchAt(const Map& map, int64_t keyframe_id, const SE3& T_w_odom, int max_keyframes) {
  if (map.FindKeyframe(keyframe_id) == nullptr) return std::nullopt;
  const std::vector<int64_t> keyframes = KeyframesAround(keyframe_id, map, kMinShared, max_keyframes);
  MapPatch patch;
  patch.T_w_odom = T_w_odom;
  for (const int64_t id : SeenBy<PointKind>(keyframes, map)) patch.points.push_back({map.FindPoint(id), {}});
  for (const int64_t id : SeenBy<LineKind>(keyframes, map)) patch.lines.push_back({map.FindLine(id), {}});
  return patch;
}

}  // namespace plslam
