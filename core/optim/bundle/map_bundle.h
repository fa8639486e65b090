// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/map/id_map.h"
#include "core/map/keyframe.h"
#include "core/map/landmark_types.h"
#include "core/optim/bundle/bundle.h"

namespace plslam {

/// Returns the observation of point `point` by a feature of keyframe `pose`; both are indices into the vectors of a
/// `BundleProblem`.
inline PointObservation ObservationOf(int pose, int point, const StereoPoint& seen) {
  return {
      pose, point, {seen.left.px.x(), seen.left.px.y(), seen.disparity_px}, seen.sigma_px, seen.sigma_disparity_px};
}

/// Sibling for lines.
inline LineObservation ObservationOf(int pose, int line, const StereoLine& seen) {
  return {pose,
          line,
          seen.left.segment,
          seen.disparity_p_px,
          seen.disparity_q_px,
          seen.sigma_px,
          seen.sigma_disparity_p_px,
          seen.sigma_disparity_q_px};
}

/// A map, or a part of it, as a bundle problem: `problem.poses[i]` belongs to `keyframes[i]`; likewise for points and
/// lines. Used by the local adjustment of mapping_process and the global one of loop_process.
struct MapBundle {
  std::vector<KeyframeId> keyframes;
  std::vector<LandmarkId> points;
  std::vector<LandmarkId> lines;
  BundleProblem problem;
};

/// Returns the problem of these keyframes and landmarks of a map: poses (`fixed`: constant ones), landmarks, and all
/// observations of the landmarks by the keyframes. The map must have them, and `features` those of the keyframes.
///
/// If `relative_sigma` is above zero, it includes the motions between consecutive keyframes of a session as tracking
/// measured them, with standard deviations times `relative_sigma`: tracking used the frames between. A motion that the
/// map contradicts by more than 30 standard deviations and more than 0.1 m or rad is left out, because the tracker was
/// lost.
MapBundle MakeMapBundle(const Map& map, const KeyframeFeatures& features, const StereoCamera& camera,
                        std::vector<KeyframeId> keyframes, const std::vector<bool>& fixed,
                        std::vector<LandmarkId> points, std::vector<LandmarkId> lines, double relative_sigma);

/// Calls visit(pose, landmark, observation) for each observation of the landmarks `ids` (points or lines of the
/// bundle), in the problem's order of observations.
template <class Type, class Visit>
void ForEachObservation(const MapBundle& bundle, const std::vector<LandmarkId>& ids, const Map& map,
                        const KeyframeFeatures& features, const Visit& visit) {
  IdMap<KeyframeId, int> poses;
  std::vector<size_t> n_features;
  for (size_t i = 0; i < bundle.keyframes.size(); ++i) {
    poses[bundle.keyframes[i]] = static_cast<int>(i);
    n_features.push_back(Type::Features(features.at(bundle.keyframes[i])).size());
  }
  for (size_t k = 0; k < ids.size(); ++k) {
    for (const Observation& observation : Type::Find(map, ids[k])->observations) {
      const int* pose = poses.Find(observation.keyframe_id());
      if (pose == nullptr) continue;
      if (static_cast<size_t>(observation.feature) < n_features[static_cast<size_t>(*pose)])
        visit(*pose, static_cast<int>(k), observation);
    }
  }
}

}  // namespace plslam
