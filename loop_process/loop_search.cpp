// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/loop_search.h"

#include <algorithm>
#include <numbers>

namespace plslam::loop {
namespace {

constexpr double kApart = 0.1;
constexpr double kApart_rad = 5.0 * std::numbers::pi / 180.0;

// Prefers a candidate that is connected to the keyframe, because its drift has been checked.
bool IsBetter(const LoopEvidence& a, const LoopEvidence& b) {
  return a.connected == b.connected ? a.place.inliers > b.place.inliers : a.connected;
}

std::optional<size_t> Strongest(const std::vector<LoopEvidence>& evidence) {
  std::optional<size_t> best;
  for (size_t i = 0; i < evidence.size(); ++i) {
    if (evidence[i].verdict != LoopVerdict::kAccepted) continue;
    if (!best || IsBetter(evidence[i], evidence[*best])) best = i;
  }
  return best;
}

// Whether two poses of a camera differ by more than a tenth of the distance of its landmarks, or by 5 deg.
bool AreTwoPlaces(const FoundPlace& a, const FoundPlace& b) {
  const SE3 apart = a.pose.T_w_kf.Inverse() * b.pose.T_w_kf;
  const double distance_m = std::max({kNearestScale_m, a.median_depth_m, b.median_depth_m});
  return apart.translation().norm() > kApart * distance_m || apart.Log().tail<3>().norm() > kApart_rad;
}

}  // namespace

bool IsRival(const FoundPlace& best, const FoundPlace& other, KeyframeId other_keyframe_id, MapPaths& paths_to_best,
             const RelocalisationOptions& options) {
  return other.inliers > options.max_rival_share * best.inliers && AreTwoPlaces(best, other) &&
         paths_to_best.From(other_keyframe_id).has_value();
}

LoopSearch FindLoop(const Map& map, const KeyframeMemory& memory, const StereoCamera& camera,
                    const LoopOptions& options, KeyframeId keyframe_id) {
  LoopSearch search;
  search.candidates = FindLoopCandidates(map, memory.places(), keyframe_id, options.candidates);
  if (const auto again = FindSecondLook(map, keyframe_id, options.candidates)) search.candidates.push_back(*again);
  if (search.candidates.empty()) return search;
  MapPaths paths(map, keyframe_id);
  for (const LoopCandidate& candidate : search.candidates) {
    search.evidence.push_back(VerifyLoop(map, memory, camera, options, paths, candidate.keyframe_id, keyframe_id));
  }
  search.best = Strongest(search.evidence);
  if (!search.best) return search;
  const LoopEvidence& best = search.evidence[*search.best];
  MapPaths paths_to_best(map, best.edge.old_keyframe_id);
  for (const LoopEvidence& other : search.evidence) {
    // Without a drift check, a rival need not pass all gates to make the loop ambiguous.
    const bool counts = other.verdict == LoopVerdict::kAccepted || !best.connected;
    const bool rival =
        counts && IsRival(best.place, other.place, other.edge.old_keyframe_id, paths_to_best, options.relocalisation);
    if (rival) search.best.reset();
    if (rival) break;
  }
  return search;
}

}  // namespace plslam::loop
