// SPDX-License-Identifier: BSD-3-Clause
#include "core/localisation/local_map.h"

#include <algorithm>
#include <array>
#include <set>

#include "core/localisation/projection_search.h"

namespace plslam {
namespace {

template <class Type>
std::vector<LandmarkId> Unassociated(const std::vector<KeyframeId>& keyframes,
                                     const std::vector<LandmarkId>& associated, const Map& map) {
  const std::set<LandmarkId> known(associated.begin(), associated.end());
  std::vector<LandmarkId> ids = SeenBy<Type>(keyframes, map);
  std::erase_if(ids, [&known](LandmarkId id) { return known.contains(id); });
  return ids;
}

// A keyframe and its predecessors in its session, each counted once.
std::map<KeyframeId, int> Before(KeyframeId keyframe_id, const Map& map, int max_keyframes) {
  std::map<KeyframeId, int> counts;
  const MapKeyframe* keyframe = map.FindKeyframe(keyframe_id);
  while (keyframe != nullptr && static_cast<int>(counts.size()) < max_keyframes) {
    counts[keyframe->id] = 1;
    keyframe = map.FindKeyframe(keyframe->previous_id);
  }
  return counts;
}

std::vector<char> WithoutLandmark(const std::vector<LandmarkId>& association) {
  std::vector<char> eligible(association.size());
  std::transform(association.begin(), association.end(), eligible.begin(),
                 [](LandmarkId id) { return id < 0 ? 1 : 0; });
  return eligible;
}

void Add(const std::vector<LandmarkFeature>& found, std::vector<LandmarkId>& association) {
  for (const LandmarkFeature& pair : found) association[static_cast<size_t>(pair.feature)] = pair.landmark_id;
}

constexpr int kEnoughExpected = 10;
constexpr double kShown = 0.1;

struct Cell {
  int expected = 0;
  int found = 0;
};
using Cells = std::array<Cell, kViewCells>;

// Adds the landmarks of one type with this weight.
template <class Type>
void Count(const Map& map, KeyframeId keyframe_id, const SE3& T_c_w, const StereoCamera& camera,
           std::vector<LandmarkId> association, int weight, Cells& cells) {
  std::sort(association.begin(), association.end());
  for (const LandmarkId id : Type::Of(map, keyframe_id)) {
    if (id < 0) continue;
    const Eigen::Vector3d p_c = T_c_w * Middle(*Type::Find(map, id));
    if (p_c.z() < camera.MinDepth()) continue;
    const Eigen::Vector2d px = camera.Project(p_c);
    if (!camera.InImage(px, 0.0)) continue;
    Cell& cell = cells[ViewCell(px, camera)];
    cell.expected += weight;
    if (std::binary_search(association.begin(), association.end(), id)) cell.found += weight;
  }
}

}  // namespace

int Association::Weight() const {
  const auto has = [](LandmarkId id) { return id >= 0; };
  return static_cast<int>(std::count_if(points.begin(), points.end(), has) +
                          2 * std::count_if(lines.begin(), lines.end(), has));
}

std::vector<KeyframeId> KeyframesAround(KeyframeId keyframe_id, const Map& map, int min_shared, int max_keyframes) {
  std::vector<KeyframeId> keyframes{keyframe_id};
  for (const Map::Neighbour& neighbour : map.Neighbours(keyframe_id, min_shared)) {
    if (static_cast<int>(keyframes.size()) >= max_keyframes) break;
    keyframes.push_back(neighbour.keyframe_id);
  }
  return keyframes;
}

LocalMap LocalMapOf(const Association& association, KeyframeId previous_id, const Map& map, int max_keyframes) {
  std::map<KeyframeId, int> counts;
  CountKeyframes<PointType>(association.points, map, counts);
  CountKeyframes<LineType>(association.lines, map, counts);
  if (counts.empty()) counts = Before(previous_id, map, max_keyframes);
  std::vector<KeyframeId> keyframes = MostCounted(counts, max_keyframes);
  // Adds their neighbours while there is room: places that the tracker has not shown to the map yet.
  const size_t n_direct = keyframes.size();
  for (size_t i = 0; i < n_direct; ++i) {
    for (const Map::Neighbour& neighbour : map.Neighbours(keyframes[i], Map::kCovisible)) {
      if (static_cast<int>(keyframes.size()) >= max_keyframes) break;
      if (std::find(keyframes.begin(), keyframes.end(), neighbour.keyframe_id) == keyframes.end()) {
        keyframes.push_back(neighbour.keyframe_id);
      }
    }
  }
  return {Unassociated<PointType>(keyframes, association.points, map),
          Unassociated<LineType>(keyframes, association.lines, map)};
}

void SearchByProjection(const Map& map, const LocalMap& local, const SE3& T_w_kf, const FeaturesView& features,
                        const StereoCamera& camera, const LocalisationOptions& options, Association& association) {
  const double radius_px = options.search_radius_px;
  const StereoCamera looked = CameraOf(features, camera);
  Add(SearchPoints(map, local.points, T_w_kf, features.points, WithoutLandmark(association.points), radius_px, looked,
                   options),
      association.points);
  Add(SearchLines(map, local.lines, T_w_kf, features.lines, WithoutLandmark(association.lines), radius_px, looked,
                  options),
      association.lines);
}

size_t ViewCell(const Eigen::Vector2d& px, const StereoCamera& camera) {
  const auto index = [](double at_px, int first_px, int size_px) {
    return std::clamp(static_cast<int>((at_px - first_px) * kViewGrid / size_px), 0, kViewGrid - 1);
  };
  return static_cast<size_t>(index(px.y(), camera.top_px, camera.height_px) * kViewGrid +
                             index(px.x(), camera.left_px, camera.width_px));
}

ExpectedLandmarks CountExpected(const Map& map, KeyframeId keyframe_id, const SE3& T_w_c, const StereoCamera& camera,
                                const Association& association) {
  Cells cells;
  const SE3 T_c_w = T_w_c.Inverse();
  Count<PointType>(map, keyframe_id, T_c_w, camera, association.points, 1, cells);
  Count<LineType>(map, keyframe_id, T_c_w, camera, association.lines, 2, cells);
  ExpectedLandmarks landmarks;
  for (const Cell& cell : cells) {
    landmarks.expected += cell.expected;
    landmarks.found += cell.found;
    if (cell.expected < kEnoughExpected) continue;
    ++landmarks.cells;
    if (cell.found >= kShown * cell.expected) ++landmarks.cells_shown;
  }
  return landmarks;
}

}  // namespace plslam
