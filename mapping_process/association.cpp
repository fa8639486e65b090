#include "mapping_process/association.h"

#include <algorithm>
#include <set>

#include "mapping_process/projection_search.h"

namespace plslam {
namespace {

// Keyframes after which a landmark of the tracker that no longer comes is forgotten; it drops them much sooner.
constexpr int64_t kRememberedKeyframes = 60;

template <class Kind, class Table>
std::vector<int64_t> ClaimsOf(size_t n, const std::vector<int64_t>& given, const std::vector<int64_t>& tracker_ids,
                              const Table& table, const Map& map) {
  std::vector<int64_t> claims(n, -1);
  std::set<int64_t> taken;
  const auto claim = [&](size_t i, int64_t id) {
    if (claims[i] < 0 && Kind::Find(map, id) != nullptr && taken.insert(id).second) claims[i] = id;
  };
  for (size_t i = 0; i < tracker_ids.size(); ++i) {
    const auto known = table.find(tracker_ids[i]);
    if (known != table.end()) claim(i, known->second.map_id);
  }
  for (size_t i = 0; i < given.size(); ++i) claim(i, given[i]);
  return claims;
}

template <class Kind>
std::vector<int64_t> Unassociated(const std::vector<int64_t>& keyframes, const std::vector<int64_t>& associated,
                                  const Map& map) {
  std::set<int64_t> ids;
  for (const int64_t keyframe_id : keyframes) {
    for (const int64_t id : Kind::Of(map, keyframe_id)) {
      if (id >= 0) ids.insert(id);
    }
  }
  for (const int64_t id : associated) ids.erase(id);
  return {ids.begin(), ids.end()};
}

// A keyframe and those before it in its session, each counted once.
std::map<int64_t, int> Before(int64_t keyframe_id, const Map& map, int max_keyframes) {
  std::map<int64_t, int> counts;
  const MapKeyframe* keyframe = map.FindKeyframe(keyframe_id);
  while (keyframe != nullptr && static_cast<int>(counts.size()) < max_keyframes) {
    counts[keyframe->id] = 1;
    keyframe = map.FindKeyframe(keyframe->previous_id);
  }
  return counts;
}

std::vector<char> WithoutLandmark(const std::vector<int64_t>& association) {
  std::vector<char> eligible(association.size());
  std::transform(association.begin(), association.end(), eligible.begin(), [](int64_t id) { return id < 0 ? 1 : 0; });
  return eligible;
}

void Add(const std::vector<LandmarkFeature>& found, std::vector<int64_t>& association) {
  for (const LandmarkFeature& pair : found) association[static_cast<size_t>(pair.feature)] = pair.landmark_id;
}

}  // namespace

int Association::Weight() const {
  const auto has = [](int64_t id) { return id >= 0; };
  return static_cast<int>(std::count_if(points.begin(), points.end(), has) +
                          2 * std::count_if(lines.begin(), lines.end(), has));
}

Association TrackerLandmarks::Claims(const Keyframe& keyframe, const Map& map) const {
  static const Table kNone;
  const bool known = keyframe.session == session_;
  return {ClaimsOf<PointKind>(keyframe.features.points.size(), keyframe.point_map_ids, keyframe.point_landmark_ids,
                              known ? points_ : kNone, map),
          ClaimsOf<LineKind>(keyframe.features.lines.size(), keyframe.line_map_ids, keyframe.line_landmark_ids,
                             known ? lines_ : kNone, map)};
}

void TrackerLandmarks::Learn(const Keyframe& keyframe, const Map::FeatureLandmarks& shown) {
  if (keyframe.session != session_) {
    session_ = keyframe.session;
    points_.clear();
    lines_.clear();
  }
  Learn(keyframe.point_landmark_ids, shown.points, keyframe.keyframe_id, points_);
  Learn(keyframe.line_landmark_ids, shown.lines, keyframe.keyframe_id, lines_);
}

void TrackerLandmarks::Learn(const std::vector<int64_t>& tracker_ids, const std::vector<int64_t>& shown,
                             int64_t keyframe_id, Table& table) {
  for (size_t i = 0; i < std::min(tracker_ids.size(), shown.size()); ++i) {
    if (tracker_ids[i] >= 0 && shown[i] >= 0) table[tracker_ids[i]] = {shown[i], keyframe_id};
  }
  std::erase_if(table, [keyframe_id](const auto& item) {
    return item.second.keyframe_id + kRememberedKeyframes < keyframe_id;
  });
}

LocalMap LocalMapOf(const Association& association, int64_t previous_id, const Map& map, int max_keyframes) {
  std::map<int64_t, int> counts;
  CountKeyframes<PointKind>(association.points, map, counts);
  CountKeyframes<LineKind>(association.lines, map, counts);
  if (counts.empty()) counts = Before(previous_id, map, max_keyframes);
  std::vector<int64_t> keyframes = MostCounted(counts, max_keyframes);
  // Their neighbours, as far as there is room: places that the tracker has not shown to the map yet.
  const size_t n_direct = keyframes.size();
  for (size_t i = 0; i < n_direct; ++i) {
    for (const Map::Neighbour& neighbour : map.Neighbours(keyframes[i], Map::kCovisible)) {
      if (static_cast<int>(keyframes.size()) >= max_keyframes) break;
      if (std::find(keyframes.begin(), keyframes.end(), neighbour.keyframe_id) == keyframes.end()) {
        keyframes.push_back(neighbour.keyframe_id);
      }
    }
  }
  return {Unassociated<PointKind>(keyframes, association.points, map),
          Unassociated<LineKind>(keyframes, association.lines, map)};
}

void SearchByProjection(const Map& map, const LocalMap& local, const SE3& T_w_kf, const StereoFeatures& features,
                        const StereoCamera& camera, const MappingOptions& options, Association& association) {
  const double radius_px = options.insertion.search_radius_px;
  Add(SearchPoints(map, local.points, T_w_kf, features.points, WithoutLandmark(association.points), radius_px, camera,
                   options),
      association.points);
  Add(SearchLines(map, local.lines, T_w_kf, features.lines, WithoutLandmark(association.lines), radius_px, camera,
                  options),
      association.lines);
}

}  // namespace plslam
