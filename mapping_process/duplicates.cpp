#include "mapping_process/duplicates.h"

#include "core/localisation/projection_search.h"
#include "mapping_process/sights.h"

namespace plslam {
namespace {

// Two landmarks are one where their distance is within so many standard deviations of either measurement.
constexpr double kSamePlaceSigmas2 = 16.0;

bool Within(const Eigen::Vector3d& difference, const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d solved = covariance.ldlt().solve(difference);
  return solved.allFinite() && difference.dot(solved) <= kSamePlaceSigmas2;
}

bool SamePlace(const MapPoint& a, const MapPoint& b) { return Within(a.p_w - b.p_w, a.covariance + b.covariance); }

// Across the line only: segments of one edge are cut differently.
bool SamePlace(const MapLine& a, const MapLine& b) {
  const Eigen::Vector3d along = (a.segment_w.q - a.segment_w.p).normalized();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along * along.transpose();
  const double length2 = (b.segment_w.q - b.segment_w.p).squaredNorm();
  const Eigen::Matrix3d free = length2 * along * along.transpose();
  return Within(across * (b.segment_w.p - a.segment_w.p), a.covariance_p + b.covariance_p + free) &&
         Within(across * (b.segment_w.q - a.segment_w.p), a.covariance_p + b.covariance_q + free);
}

// Landmarks of one keyframe that another does not see.
template <class Kind>
std::vector<int64_t> UnseenBy(int64_t other_id, int64_t keyframe_id, const Map& map) {
  std::vector<int64_t> ids;
  for (const int64_t id : Kind::Of(map, keyframe_id)) {
    if (id >= 0 && !IsSeenBy(*Kind::Find(map, id), other_id)) ids.push_back(id);
  }
  return ids;
}

template <class Kind>
void Merge(const std::vector<LandmarkFeature>& found, int64_t keyframe_id, const KeyframeFeatures& features,
           Map& map) {
  for (const LandmarkFeature& pair : found) {
    const Sight sight{keyframe_id, pair.feature};
    const int64_t shown = LandmarkAt<Kind>(map, sight);
    if (shown < 0) {
      AddSight<Kind>(pair.landmark_id, sight, features, map);
      continue;
    }
    const auto* a = Kind::Find(map, shown);
    const auto* b = Kind::Find(map, pair.landmark_id);
    if (a != nullptr && b != nullptr && SamePlace(*a, *b)) Fuse<Kind>(shown, pair.landmark_id, features, map);
  }
}

// Landmarks of `from` searched among all features of `to`.
void MergeInto(int64_t to, int64_t from, const KeyframeFeatures& features, const StereoCamera& camera,
               const MappingOptions& options, Map& map) {
  const StereoFeatures& seen = features.at(to);
  const SE3 T_w_kf = map.FindKeyframe(to)->T_w_kf;
  const double radius_px = options.insertion.fuse_radius_px;
  Merge<PointKind>(SearchPoints(map, UnseenBy<PointKind>(to, from, map), T_w_kf, seen.points,
                                std::vector<char>(seen.points.size(), 1), radius_px, camera, options.localisation),
                   to, features, map);
  Merge<LineKind>(SearchLines(map, UnseenBy<LineKind>(to, from, map), T_w_kf, seen.lines,
                              std::vector<char>(seen.lines.size(), 1), radius_px, camera, options.localisation),
                  to, features, map);
}

}  // namespace

void MergeWithNeighbours(int64_t keyframe_id, const KeyframeFeatures& features, const StereoCamera& camera,
                         const MappingOptions& options, Map& map) {
  int left = options.insertion.fuse_keyframes;
  for (const Map::Neighbour& neighbour : map.Neighbours(keyframe_id, options.window.min_shared)) {
    if (left-- == 0) break;
    MergeInto(neighbour.keyframe_id, keyframe_id, features, camera, options, map);
    MergeInto(keyframe_id, neighbour.keyframe_id, features, camera, options, map);
  }
}

}  // namespace plslam
