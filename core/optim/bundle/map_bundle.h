// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/map/id_map.h"
#include "core/map/keyframe.h"
#include "core/map/landmark_types.h"
#include "core/optim/bundle/bundle.h"

namespace plslam {

/// What a feature of keyframe `pose` measures of point `point`; both are indices into the vectors of a
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

/// A map, or a part of it, as a bundle problem: `problem.poses[i]` is of `keyframes[i]`, and so for points and lines.
/// Both the local adjustment of mapping_process and the global one of loop_process are built here.
struct MapBundle {
  std::vector<int64_t> keyframes;
  std::vector<int64_t> points;
  std::vector<int64_t> lines;
  BundleProblem problem;
};

/// The problem of these keyframes and landmarks of a map, which must have them: poses (`fixed`: those that are
/// constant), landmarks, and all observations of the landmarks by the keyframes, whose features must be there.
///
/// With `relative_sigma` above zero it also has the motions between consecutive keyframes of a session as tracking
/// measured them, with standard deviations times `relative_sigma`: tracking has seen the frames between. A motion
/// that the map contradicts is left out, since the tracker was lost meanwhile: one that is off by more than 30
/// standard deviations and by more than 0.1 m or rad.
MapBundle MakeMapBundle(const Map& map, const KeyframeFeatures& features, const StereoCamera& camera,
                        std::vector<int64_t> keyframes, const std::vector<bool>& fixed, std::vector<int64_t> points,
                        std::vector<int64_t> lines, double relative_sigma);

/// Calls visit(pose, landmark, observation) for each observation in a bundle of the landmarks `ids` (its points or
/// its lines), in the order of the problem's.
template <class Type, class Visit>
void ForEachObservation(const MapBundle& bundle, const std::vector<int64_t>& ids, const Map& map,
                        const KeyframeFeatures& features, const Visit& visit) {
  IdMap<int> poses;
  std::vector<size_t> n_features;
  for (size_t i = 0; i < bundle.keyframes.size(); ++i) {
    poses[bundle.keyframes[i]] = static_cast<int>(i);
    n_features.push_back(Type::Features(features.at(bundle.keyframes[i])).size());
  }
  for (size_t k = 0; k < ids.size(); ++k) {
    for (const Observation& observation : Type::Find(map, ids[k])->observations) {
      const int* pose = poses.Find(observation.keyframe_id);
      if (pose == nullptr) continue;
      if (static_cast<size_t>(observation.feature) < n_features[static_cast<size_t>(*pose)])
        visit(*pose, static_cast<int>(k), observation);
    }
  }
}

}  // namespace plslam
