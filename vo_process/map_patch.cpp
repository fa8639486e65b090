#include "vo_process/map_patch.h"

#include <algorithm>
#include <set>
#include <utility>

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

void Collect(const std::vector<int64_t>& seen, std::set<int64_t>& ids) {
  for (const int64_t id : seen) {
    if (id >= 0) ids.insert(id);
  }
}

struct Seen {
  std::vector<const MapPoint*> points;
  std::vector<const MapLine*> lines;
};

// By a keyframe and its best neighbours; ascending.
Seen SeenAround(const Map& map, int64_t keyframe_id, int max_keyframes) {
  std::set<int64_t> point_ids;
  std::set<int64_t> line_ids;
  const auto collect = [&](int64_t id) {
    Collect(map.LandmarksOf(id).points, point_ids);
    Collect(map.LandmarksOf(id).lines, line_ids);
  };
  collect(keyframe_id);
  int left = max_keyframes;
  for (const Map::Neighbour& neighbour : map.Neighbours(keyframe_id, kMinShared)) {
    if (--left <= 0) break;
    collect(neighbour.keyframe_id);
  }
  Seen seen;
  seen.points.reserve(point_ids.size());
  for (const int64_t id : point_ids) seen.points.push_back(map.FindPoint(id));
  seen.lines.reserve(line_ids.size());
  for (const int64_t id : line_ids) seen.lines.push_back(map.FindLine(id));
  return seen;
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

template <class Landmark>
std::vector<Adopted<Landmark>> KeyframeLog::Adopt(const Map& map, int64_t session,
                                                  const std::vector<const Landmark*>& landmarks,
                                                  std::vector<int64_t> Entry::*ids) const {
  std::vector<Adopted<Landmark>> adopted;
  for (const Landmark* landmark : landmarks) {
    Adopted<Landmark>& entry = adopted.emplace_back(Adopted<Landmark>{landmark, {}});
    for (const Sight& sight : landmark->sights) {
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
  const Seen seen = SeenAround(map, center->id, max_keyframes);
  MapPatch patch;
  patch.T_w_odom = center->T_w_kf * center->T_odom_kf.Inverse();
  patch.points = Adopt(map, session, seen.points, &Entry::point_ids);
  patch.lines = Adopt(map, session, seen.lines, &Entry::line_ids);
  return patch;
}

std::optional<MapPatch> PatchAt(const Map& map, int64_t keyframe_id, const SE3& T_w_odom, int max_keyframes) {
  if (map.FindKeyframe(keyframe_id) == nullptr) return std::nullopt;
  const Seen seen = SeenAround(map, keyframe_id, max_keyframes);
  MapPatch patch;
  patch.T_w_odom = T_w_odom;
  for (const MapPoint* point : seen.points) patch.points.push_back({point, {}});
  for (const MapLine* line : seen.lines) patch.lines.push_back({line, {}});
  return patch;
}

}  // namespace plslam
