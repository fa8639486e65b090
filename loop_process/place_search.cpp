#include "loop_process/place_search.h"

#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include "core/motion/robust.h"

namespace plslam {
namespace {

// Keyframes whose landmarks are compared by descriptor alone; more bring more rivals than matches.
constexpr int kDescribed = 3;
constexpr int kGrid = 4;
constexpr double kMinDepth_m = 0.05;

template <class Kind>
std::vector<int64_t> SeenBy(const std::vector<int64_t>& keyframes, const Map& map) {
  std::set<int64_t> ids;
  for (const int64_t keyframe_id : keyframes) {
    for (const int64_t id : Kind::Of(map, keyframe_id)) {
      if (id >= 0) ids.insert(id);
    }
  }
  return {ids.begin(), ids.end()};
}

// Where a landmark should appear; nullopt where it is not in view.
std::optional<Eigen::Vector2d> Projection(const Eigen::Vector3d& p_w, const SE3& T_c_w, const StereoCamera& camera) {
  const Eigen::Vector3d p_c = T_c_w * p_w;
  if (p_c.z() < kMinDepth_m) return std::nullopt;
  const Eigen::Vector2d px = camera.Project(p_c);
  return camera.InImage(px, 0.0) ? std::optional(px) : std::nullopt;
}

Eigen::Vector3d Middle(const MapPoint& point) { return point.p_w; }
Eigen::Vector3d Middle(const MapLine& line) { return 0.5 * (line.segment_w.p + line.segment_w.q); }
Eigen::Vector2d Middle(const StereoPoint& point) { return point.left.px; }
Eigen::Vector2d Middle(const StereoLine& line) { return 0.5 * (line.left.segment.p + line.left.segment.q); }

// Evidence of one kind, each landmark with this weight.
template <class Kind>
void Count(const Map& map, int64_t keyframe_id, const SE3& T_c_w, const StereoCamera& camera,
           const std::vector<int64_t>& association, int weight, FoundPlace& place) {
  const std::set<int64_t> shown(association.begin(), association.end());
  for (const int64_t id : Kind::Of(map, keyframe_id)) {
    if (id < 0 || !Projection(Middle(*Kind::Find(map, id)), T_c_w, camera)) continue;
    place.expected += weight;
    if (shown.contains(id)) place.found += weight;
  }
}

template <class Kind>
void Spread(const Map& map, const SE3& T_c_w, const StereoCamera& camera,
            const std::vector<typename Kind::Feature>& features, const std::vector<int64_t>& association,
            std::array<bool, kGrid * kGrid>& cells, std::vector<double>& depths) {
  for (size_t i = 0; i < association.size(); ++i) {
    if (association[i] < 0) continue;
    const Eigen::Vector2d px = Middle(features[i]);
    const int column = std::clamp(static_cast<int>(px.x() * kGrid / camera.width_px), 0, kGrid - 1);
    const int row = std::clamp(static_cast<int>(px.y() * kGrid / camera.height_px), 0, kGrid - 1);
    cells[static_cast<size_t>(row * kGrid + column)] = true;
    depths.push_back((T_c_w * Middle(*Kind::Find(map, association[i]))).z());
  }
}

void Weigh(const Map& map, int64_t keyframe_id, const StereoFeatures& features, const StereoCamera& camera,
           FoundPlace& place) {
  const SE3 T_c_w = place.pose.T_w_kf.Inverse();
  place.inliers = place.association.Weight();
  Count<PointKind>(map, keyframe_id, T_c_w, camera, place.association.points, 1, place);
  Count<LineKind>(map, keyframe_id, T_c_w, camera, place.association.lines, 2, place);
  std::array<bool, kGrid * kGrid> cells{};
  std::vector<double> depths;
  Spread<PointKind>(map, T_c_w, camera, features.points, place.association.points, cells, depths);
  Spread<LineKind>(map, T_c_w, camera, features.lines, place.association.lines, cells, depths);
  place.cells = static_cast<int>(std::count(cells.begin(), cells.end(), true));
  place.median_depth_m = Median(depths);
}

}  // namespace

LocalMap LandmarksAround(const Map& map, int64_t keyframe_id, int max_keyframes) {
  std::vector<int64_t> keyframes{keyframe_id};
  for (const Map::Neighbour& neighbour : map.Neighbours(keyframe_id, Map::kCovisible)) {
    if (static_cast<int>(keyframes.size()) >= max_keyframes) break;
    keyframes.push_back(neighbour.keyframe_id);
  }
  return {SeenBy<PointKind>(keyframes, map), SeenBy<LineKind>(keyframes, map)};
}

std::optional<FoundPlace> FindPlace(const Map& map, int64_t keyframe_id, const StereoFeatures& features,
                                    const StereoCamera& camera, const LocalisationOptions& options,
                                    int local_keyframes, int min_matches) {
  Association association;
  const LocalMap described = LandmarksAround(map, keyframe_id, kDescribed);
  const auto pose = RecognisePose(map, described, features, camera, options, min_matches, association);
  if (!pose) return std::nullopt;
  return FindPlaceNear(map, keyframe_id, pose->T_w_kf, features, camera, options, local_keyframes);
}

std::optional<FoundPlace> FindPlaceNear(const Map& map, int64_t keyframe_id, const SE3& T_w_c,
                                        const StereoFeatures& features, const StereoCamera& camera,
                                        const LocalisationOptions& options, int local_keyframes) {
  const LocalMap local = LandmarksAround(map, keyframe_id, local_keyframes);
  FoundPlace place;
  place.pose.T_w_kf = T_w_c;
  for (int round = 0; round < 2; ++round) {
    // Anew each time: what was matched from a worse pose is no evidence.
    place.association = {std::vector<int64_t>(features.points.size(), -1),
                         std::vector<int64_t>(features.lines.size(), -1)};
    SearchByProjection(map, local, place.pose.T_w_kf, features, camera, options, place.association);
    place.matches = place.association.Weight();
    const auto pose = RefinePose(map, features, camera, place.pose.T_w_kf, options.motion, place.association);
    if (!pose) return std::nullopt;
    place.pose = *pose;
  }
  Weigh(map, keyframe_id, features, camera, place);
  return place;
}

}  // namespace plslam
