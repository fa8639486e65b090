#include "loop_process/loop_search.h"

#include <algorithm>
#include <numbers>

namespace plslam {
namespace {

constexpr double kApart = 0.1;
constexpr double kApart_rad = 5.0 * std::numbers::pi / 180.0;

std::optional<size_t> Strongest(const std::vector<LoopEvidence>& evidence) {
  std::optional<size_t> best;
  for (size_t i = 0; i < evidence.size(); ++i) {
    if (evidence[i].verdict != LoopVerdict::kAccepted) continue;
    if (!best || evidence[i].place.inliers > evidence[*best].place.inliers) best = i;
  }
  return best;
}

}  // namespace

bool AreTwoPlaces(const FoundPlace& a, const FoundPlace& b) {
  const SE3 apart = a.pose.T_w_kf.Inverse() * b.pose.T_w_kf;
  const double distance_m = std::max({kNearestScale_m, a.median_depth_m, b.median_depth_m});
  return apart.translation().norm() > kApart * distance_m || apart.Log().tail<3>().norm() > kApart_rad;
}

LoopSearch FindLoop(const Map& map, const KeyframeMemory& memory, const StereoCamera& camera,
                    const LoopOptions& options, int64_t keyframe_id) {
  LoopSearch search;
  search.candidates = FindLoopCandidates(map, memory.places(), keyframe_id, options.candidates);
  if (const auto again = FindSecondLook(map, keyframe_id, options.candidates)) search.candidates.push_back(*again);
  if (search.candidates.empty()) return search;
  MapWays ways(map, keyframe_id);
  for (const LoopCandidate& candidate : search.candidates) {
    search.evidence.push_back(VerifyLoop(map, memory, camera, options, ways, candidate.keyframe_id, keyframe_id));
  }
  search.best = Strongest(search.evidence);
  if (!search.best) return search;
  const FoundPlace& best = search.evidence[*search.best].place;
  for (const LoopEvidence& other : search.evidence) {
    // Where drift tells nothing, another place need not pass all gates to cast doubt.
    const bool counts = other.verdict == LoopVerdict::kAccepted || !search.evidence[*search.best].connected;
    const bool rival = counts && AreTwoPlaces(best, other.place) &&
                       other.place.inliers > options.relocalisation.max_rival_share * best.inliers;
    if (rival) search.best.reset();
    if (rival) break;
  }
  return search;
}

}  // namespace plslam
