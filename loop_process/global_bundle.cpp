// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/global_bundle.h"

#include <algorithm>
#include <utility>

#include "core/optim/bundle/map_bundle.h"

namespace plslam::loop {
namespace {

using Places = IdMap<KeyframeId, int>;

SourceId NumberingOf(const GlobalBundleProblem& problem) {
  return problem.map_version ? problem.map_version->numbering : SourceId();
}

// Counts the observations of a landmark by keyframes that take part.
template <class Landmark>
int CountObservations(const Landmark& landmark, const Places& poses) {
  return static_cast<int>(
      std::count_if(landmark.observations.begin(), landmark.observations.end(),
                    [&poses](const Observation& observation) { return poses.contains(observation.keyframe_id()); }));
}

// Chooses for each keyframe the landmarks seen by most keyframes, up to `per_keyframe`, including those already
// chosen for another keyframe.
template <class Type>
std::vector<LandmarkId> Choose(const Map& map, const Places& poses, int min_observations, int per_keyframe) {
  struct Candidate {
    int observations = 0;
    bool is_chosen = false;
  };
  IdMap<LandmarkId, Candidate> candidates;
  for (const auto& [id, landmark] : Type::Landmarks(map)) {
    const int count = CountObservations(landmark, poses);
    if (count >= min_observations) candidates[id].observations = count;
  }
  std::vector<std::pair<LandmarkId, Candidate*>> seen;
  for (const auto& [keyframe_id, place] : poses) {
    seen.clear();
    int taken = 0;
    for (const LandmarkId id : Type::Of(map, keyframe_id)) {
      Candidate* candidate = id < 0 ? nullptr : candidates.Find(id);
      if (candidate == nullptr) continue;
      if (candidate->is_chosen) {
        ++taken;
      } else {
        seen.emplace_back(id, candidate);
      }
    }
    std::stable_sort(seen.begin(), seen.end(),
                     [](const auto& a, const auto& b) { return a.second->observations > b.second->observations; });
    for (size_t i = 0; i < seen.size() && taken < per_keyframe; ++i, ++taken) seen[i].second->is_chosen = true;
  }
  std::vector<LandmarkId> chosen;
  for (const auto& [id, candidate] : candidates) {
    if (candidate.is_chosen) chosen.push_back(id);
  }
  return chosen;
}

}  // namespace

GlobalBundleProblem MakeGlobalBundleProblem(const Map& map, const KeyframeFeatures& features,
                                            const StereoCamera& camera, const GlobalBundleOptions& options) {
  GlobalBundleProblem problem;
  std::vector<KeyframeId> keyframes;
  Places poses;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (!features.contains(id)) continue;
    poses[id] = static_cast<int>(keyframes.size());
    keyframes.push_back(id);
    problem.keyframes.push_back({id, keyframe.name});
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

void AdjustmentProgress::Add(const GlobalBundleProblem& problem, const std::vector<CorrectedPose>& poses) {
  if (NumberingOf(problem) != numbering_) T_before_now_.clear();
  numbering_ = NumberingOf(problem);
  for (size_t i = 0; i < poses.size(); ++i) {
    SE3& T_before_now = T_before_now_[poses[i].keyframe_id];
    T_before_now = T_before_now * (problem.bundle.poses[i].T_w_c.Inverse() * poses[i].T_w_kf);
  }
}

void AdjustmentProgress::Apply(GlobalBundleProblem& problem) const {
  if (NumberingOf(problem) != numbering_) return;
  BundleProblem& bundle = problem.bundle;
  std::vector<SE3> T_new_old(bundle.poses.size());  // displacement in the map frame
  for (size_t i = 0; i < bundle.poses.size(); ++i) {
    const auto found = T_before_now_.find(problem.keyframes[i].keyframe_id);
    if (found == T_before_now_.end() || bundle.poses[i].fixed) continue;
    const SE3 T_w_kf = bundle.poses[i].T_w_c;
    bundle.poses[i].T_w_c = T_w_kf * found->second;
    T_new_old[i] = bundle.poses[i].T_w_c * T_w_kf.Inverse();
  }
  std::vector<bool> moved_points(bundle.points.size());
  for (const PointObservation& observation : bundle.point_observations) {
    const auto point = static_cast<size_t>(observation.point);
    if (moved_points[point]) continue;
    moved_points[point] = true;
    bundle.points[point].p_w = T_new_old[static_cast<size_t>(observation.pose)] * bundle.points[point].p_w;
  }
  std::vector<bool> moved_lines(bundle.lines.size());
  for (const LineObservation& observation : bundle.line_observations) {
    const auto line = static_cast<size_t>(observation.line);
    if (moved_lines[line]) continue;
    moved_lines[line] = true;
    Segment3& segment_w = bundle.lines[line].segment_w;
    const SE3& T = T_new_old[static_cast<size_t>(observation.pose)];
    segment_w = {T * segment_w.p, T * segment_w.q};
  }
}

LoopClosure AdjustGlobally(const GlobalBundleProblem& problem, const GlobalBundleOptions& options,
                           const std::atomic<bool>* stop, std::string* failure) {
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kAdjustment;
  closure.keyframe = problem.keyframe;
  closure.t_ns = problem.t_ns;
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

}  // namespace plslam::loop
