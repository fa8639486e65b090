// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/duplicates.h"

#include "core/geometry/symmetric.h"
#include "core/localisation/projection_search.h"
#include "mapping_process/insertion/observations.h"

namespace plslam::mapping {
namespace {

// Squared gate: two landmarks are the same if their distance is within four standard deviations of both together.
constexpr double kSamePlaceSigmas2 = 16.0;

bool Within(const Eigen::Vector3d& difference, const Eigen::Matrix3d& covariance) {
  return SquaredMahalanobis<3>(difference, covariance) <= kSamePlaceSigmas2;
}

// `slack` is an additional variance in m^2, on each axis.
bool SamePlace(const MapPoint& a, const MapPoint& b, double slack) {
  return Within(a.p_w - b.p_w, a.covariance.matrix() + b.covariance.matrix() + slack * Eigen::Matrix3d::Identity());
}

// Compares across the line only, because detectors cut the same edge differently.
bool SamePlace(const MapLine& a, const MapLine& b, double slack) {
  const Eigen::Vector3d along = (a.segment_w.q - a.segment_w.p).normalized();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along * along.transpose();
  const double length2 = (b.segment_w.q - b.segment_w.p).squaredNorm();
  const Eigen::Matrix3d free = length2 * along * along.transpose() + slack * Eigen::Matrix3d::Identity();
  return Within(across * (b.segment_w.p - a.segment_w.p), a.covariance_p.matrix() + b.covariance_p.matrix() + free) &&
         Within(across * (b.segment_w.q - a.segment_w.p), a.covariance_p.matrix() + b.covariance_q.matrix() + free);
}

// Landmarks of one keyframe that another does not observe.
template <class Type>
std::vector<LandmarkId> UnseenBy(KeyframeId other_id, KeyframeId keyframe_id, const Map& map) {
  std::vector<LandmarkId> ids = Type::Of(map, keyframe_id);
  LeaveOutSeen<Type>(other_id, map, ids);
  return ids;
}

// `spread_m` is the additional standard deviation at a distance of one metre.
template <class Type>
void Merge(const std::vector<LandmarkFeature>& found, KeyframeId keyframe_id, double spread_m,
           const KeyframeFeatures& features, Map& map) {
  const Eigen::Vector3d centre_w = map.FindKeyframe(keyframe_id)->T_w_kf.translation();
  for (const LandmarkFeature& pair : found) {
    const Observation observation{keyframe_id, pair.feature};
    const LandmarkId shown = LandmarkAt<Type>(map, observation);
    if (shown < 0) {
      AddObservation<Type>(pair.landmark_id, observation, features, map);
      continue;
    }
    const auto* a = Type::Find(map, shown);
    const auto* b = Type::Find(map, pair.landmark_id);
    if (a == nullptr || b == nullptr) continue;
    const double slack = spread_m * spread_m * (Middle(*a) - centre_w).squaredNorm();
    if (SamePlace(*a, *b, slack)) Fuse<Type>(shown, pair.landmark_id, features, map);
  }
}

}  // namespace

void MergeInto(KeyframeId keyframe_id, const LocalMap& landmarks, const MergeWindow& window,
               const KeyframeFeatures& features, const StereoCamera& camera, const LocalisationOptions& options,
               Map& map) {
  const FeaturesView& seen = features.at(keyframe_id);
  const SE3 T_w_kf = map.FindKeyframe(keyframe_id)->T_w_kf;
  const double spread_m = window.sigma_px / camera.f_px;
  const StereoCamera seen_by = CameraOf(seen, camera);
  Merge<PointType>(SearchPoints(map, landmarks.points, T_w_kf, seen.points, std::vector<char>(seen.points.size(), 1),
                                window.radius_px, seen_by, options),
                   keyframe_id, spread_m, features, map);
  Merge<LineType>(SearchLines(map, landmarks.lines, T_w_kf, seen.lines, std::vector<char>(seen.lines.size(), 1),
                              window.radius_px, seen_by, options),
                  keyframe_id, spread_m, features, map);
}

void MergeWithNeighbours(KeyframeId keyframe_id, const KeyframeFeatures& features, const StereoCamera& camera,
                         const MappingOptions& options, Map& map) {
  const MergeWindow window{options.insertion.fuse_radius_px, 0.0};
  const auto merge = [&](KeyframeId to, KeyframeId from) {
    const LocalMap unseen{UnseenBy<PointType>(to, from, map), UnseenBy<LineType>(to, from, map)};
    MergeInto(to, unseen, window, features, camera, options.localisation, map);
  };
  int left = options.insertion.fuse_keyframes;
  for (const Map::Neighbour& neighbour : map.Neighbours(keyframe_id, options.window.min_shared)) {
    if (left-- == 0) break;
    merge(neighbour.keyframe_id, keyframe_id);
    merge(keyframe_id, neighbour.keyframe_id);
  }
}

}  // namespace plslam::mapping
