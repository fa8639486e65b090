// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/whole_map.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "core/optim/bundle/map_bundle.h"

namespace plslam {
namespace {

using Places = std::map<int64_t, int>;

// Observations of a landmark by keyframes that take part.
template <class Landmark>
int CountObservations(const Landmark& landmark, const Places& poses) {
  return static_cast<int>(
      std::count_if(landmark.observations.begin(), landmark.observations.end(),
                    [&poses](const Observation& observation) { return poses.contains(observation.keyframe_id); }));
}

// Of each keyframe the landmarks that most others see, until it has enough; those already taken for another one
// count.
template <class Type>
std::vector<int64_t> Choose(const Map& map, const Places& poses, int min_observations, int per_keyframe) {
  std::map<int64_t, int> observations;
  for (const auto& [id, landmark] : Type::Landmarks(map)) {
    const int count = CountObservations(landmark, poses);
    if (count >= min_observations) observations[id] = count;
  }
  std::set<int64_t> chosen;
  for (const auto& [keyframe_id, place] : poses) {
    std::vector<int64_t> seen;
    int taken = 0;
    for (const int64_t id : Type::Of(map, keyframe_id)) {
      if (id < 0 || !observations.contains(id)) continue;
      if (chosen.contains(id)) {
        ++taken;
      } else {
        seen.push_back(id);
      }
    }
    std::stable_sort(seen.begin(), seen.end(),
                     [&observations](int64_t a, int64_t b) { return observations.at(a) > observations.at(b); });
    for (size_t i = 0; i < seen.size() && taken < per_keyframe; ++i, ++taken) chosen.insert(seen[i]);
  }
  return {chosen.begin(), chosen.end()};
}

}  // namespace

WholeMapProblem MakeWholeMapProblem(const Map& map, const KeyframeFeatures& features, const StereoCamera& camera,
                                    const WholeMapOptions& options) {
  WholeMapProblem problem;
  std::vector<int64_t> keyframes;
  Places poses;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (!features.contains(id)) continue;
    poses[id] = static_cast<int>(keyframes.size());
    keyframes.push_back(id);
    problem.keyframes.push_back({id, keyframe.session, keyframe.session_keyframe_id});
  }
  std::vector<bool> fixed(keyframes.size());
  if (!fixed.empty()) fixed.front() = true;
  problem.bundle = MakeMapBundle(map, features, camera, std::move(keyframes), fixed,
                                 Choose<PointType>(map, poses, options.min_observations, options.points_per_keyframe),
                                 Choose<LineType>(map, poses, options.min_observations, options.lines_per_keyframe),
                                 options.relative_sigma)
                       .problem;
  return problem;
}

LoopClosure AdjustWholeMap(const WholeMapProblem& problem, const WholeMapOptions& options,
                           const std::atomic<bool>* stop, std::string* failure) {
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kAdjustment;
  closure.session = problem.session;
  closure.session_keyframe_id = problem.session_keyframe_id;
  closure.t_ns = problem.t_ns;
  closure.map_source = problem.map_source;
  closure.map_version = problem.map_version;
  const BundleResult result = AdjustBundle(problem.bundle, options.bundle, stop, BundleCovariances::kNone);
  if (!result.ok) {
    if (failure != nullptr) *failure = result.reason;
    return closure;
  }
  for (size_t i = 0; i < problem.keyframes.size(); ++i) {
    closure.poses.push_back({problem.keyframes[i].keyframe_id, result.T_w_c[i]});
  }
  closure.names = problem.keyframes;
  return closure;
}

}  // namespace plslam
