// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/map_bundle.h"

#include <Eigen/Cholesky>
#include <map>
#include <utility>

#include "core/geometry/symmetric.h"

namespace plslam {
namespace {

// Gates on the error of a tracker's motion in the map: squared, in standard deviations; and in metres or radians,
// because the standard deviations of a standing camera are tiny.
constexpr double kContradicted2 = 900.0;
constexpr double kContradicted = 0.1;
// In problems with more keyframes, features are released from memory after each keyframe (`KeptFeatures::LeaveMemory`).
constexpr size_t kMostInMemory = 256;

bool IsContradicted(const SE3& error, const Matrix6d& covariance) {
  const Vector6d e = error.Log();
  return e.norm() > kContradicted && SquaredMahalanobis<6>(e, covariance) > kContradicted2;
}

void AddMotions(const Map& map, double relative_sigma, MapBundle& bundle) {
  std::map<KeyframeId, int> poses;
  for (size_t i = 0; i < bundle.keyframes.size(); ++i) poses[bundle.keyframes[i]] = static_cast<int>(i);
  for (const auto& [id, pose] : poses) {
    const MapKeyframe& keyframe = *map.FindKeyframe(id);
    const auto previous = poses.find(keyframe.previous_id);
    if (previous == poses.end()) continue;
    const Matrix6d covariance = relative_sigma * relative_sigma * keyframe.relative_covariance;
    const SE3 T_prevkf_kf = map.FindKeyframe(previous->first)->T_w_kf.Inverse() * keyframe.T_w_kf;
    if (IsContradicted(keyframe.T_prevkf_kf.Inverse() * T_prevkf_kf, covariance)) continue;
    bundle.problem.relative_poses.push_back({previous->second, pose, keyframe.T_prevkf_kf, covariance});
  }
}

template <class Type, class BundleObservation>
void AddObservations(const std::vector<LandmarkId>& ids, const Map& map, const KeyframeFeatures& features,
                     const MapBundle& bundle, std::vector<BundleObservation>& observations) {
  struct Seen {
    size_t place;
    int landmark;
    int32_t feature;
  };
  // Keyframe by keyframe, so that features in files are in memory for one at a time.
  std::vector<std::vector<Seen>> seen(bundle.keyframes.size());
  size_t count = 0;
  ForEachObservation<Type>(bundle, ids, map, features, [&](int pose, int landmark, const Observation& observation) {
    seen[static_cast<size_t>(pose)].push_back({count++, landmark, observation.feature});
  });
  observations.resize(count);
  for (size_t pose = 0; pose < seen.size(); ++pose) {
    if (seen[pose].empty()) continue;
    const KeptFeatures& of_keyframe = features.at(bundle.keyframes[pose]);
    for (const auto& [place, landmark, feature] : seen[pose]) {
      observations[place] =
          ObservationOf(static_cast<int>(pose), landmark, Type::Features(of_keyframe)[static_cast<size_t>(feature)]);
    }
    if (seen.size() > kMostInMemory) of_keyframe.LeaveMemory();
  }
}

}  // namespace

MapBundle MakeMapBundle(const Map& map, const KeyframeFeatures& features, const StereoCamera& camera,
                        std::vector<KeyframeId> keyframes, const std::vector<bool>& fixed,
                        std::vector<LandmarkId> points, std::vector<LandmarkId> lines, double relative_sigma) {
  MapBundle bundle{std::move(keyframes), std::move(points), std::move(lines), {}};
  BundleProblem& problem = bundle.problem;
  problem.camera = camera;
  for (size_t i = 0; i < bundle.keyframes.size(); ++i) {
    problem.poses.push_back({map.FindKeyframe(bundle.keyframes[i])->T_w_kf, fixed[i]});
  }
  for (const LandmarkId id : bundle.points) problem.points.push_back({map.FindPoint(id)->p_w});
  for (const LandmarkId id : bundle.lines) problem.lines.push_back({map.FindLine(id)->segment_w});
  AddObservations<PointType>(bundle.points, map, features, bundle, problem.point_observations);
  AddObservations<LineType>(bundle.lines, map, features, bundle, problem.line_observations);
  if (relative_sigma > 0.0) AddMotions(map, relative_sigma, bundle);
  return bundle;
}

}  // namespace plslam
