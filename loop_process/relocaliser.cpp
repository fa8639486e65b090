// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/relocaliser.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <optional>
#include <vector>

#include "core/geometry/symmetric.h"
#include "loop_process/loop_candidates.h"
#include "loop_process/loop_search.h"
#include "loop_process/map_path.h"
#include "loop_process/place_search.h"

namespace plslam::loop {
namespace {

struct Answer {
  KeyframeId keyframe_id = -1;
  FoundPlace place;
};

bool IsGood(const FoundPlace& place, const LoopOptions& options) {
  return place.inliers >= options.relocalisation.min_inliers &&
         place.landmarks.Share() >= options.relocalisation.min_inlier_share &&
         place.cells >= options.verification.min_cells &&
         EigenOf<6>(place.pose.covariance).values(5) <= options.verification.max_eigenvalue;
}

int32_t CountShown(const std::vector<LandmarkId>& ids) {
  return static_cast<int32_t>(std::count_if(ids.begin(), ids.end(), [](LandmarkId id) { return id >= 0; }));
}

Relocalisation ToRelocalisation(const Answer& answer) {
  Relocalisation relocalisation;
  relocalisation.found = true;
  relocalisation.keyframe_id = answer.keyframe_id;
  relocalisation.T_w_c = answer.place.pose.T_w_kf;
  relocalisation.covariance = answer.place.pose.covariance;
  relocalisation.n_points = CountShown(answer.place.association.points);
  relocalisation.n_lines = CountShown(answer.place.association.lines);
  return relocalisation;
}

}  // namespace

Relocalisation FindCamera(const Map& map, const KeyframeMemory& memory, const FeaturesView& features,
                          const StereoCamera& camera, const LoopOptions& options) {
  std::optional<Answer> best;
  std::vector<Answer> all;
  FeatureNodes nodes;
  const PlaceDescription description = DescribePlace(memory.places(), features, nodes);
  for (const LoopCandidate& candidate :
       FindPlaceCandidates(map, memory.places(), description, options.candidates, options.relocalisation.max_queried,
                           options.relocalisation.max_candidates)) {
    const KeyframeId id = candidate.keyframe_id;
    const DescribedImage then{memory.features().at(id), memory.point_nodes().at(id)};
    const auto guess =
        GuessPose(map, id, then, {features, nodes}, camera, options.localisation, options.verification.min_matches);
    if (!guess) continue;
    const auto place = FindPlace(map, PlaceAround(map, id, options.verification.local_keyframes), guess->T_w_kf,
                                 features, camera, options.localisation);
    if (!place) continue;
    all.push_back({id, *place});
    if (!IsGood(*place, options)) continue;
    if (!best || place->inliers > best->place.inliers) best = all.back();
  }
  if (!best) return {};
  MapPaths paths_to_best(map, best->keyframe_id);
  const bool rivalled = std::any_of(all.begin(), all.end(), [&](const Answer& other) {
    return IsRival(best->place, other.place, other.keyframe_id, paths_to_best, options.relocalisation);
  });
  return rivalled ? Relocalisation() : ToRelocalisation(*best);
}

}  // namespace plslam::loop
