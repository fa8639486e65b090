// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/loop_correction.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "core/map/map_graph.h"
#include "core/optim/pose_graph/map_pose_graph.h"

namespace plslam::loop {
namespace {

// Keyframes of the parts of the map that the loop joins, connected by known or unknown steps.
std::set<KeyframeId> Touched(const LoopEdge& loop, const MapGraph& graph) {
  std::set<KeyframeId> touched = graph.Component(loop.old_keyframe_id, MapGraph::Edges::kAll);
  if (!touched.contains(loop.keyframe_id)) {
    touched.merge(graph.Component(loop.keyframe_id, MapGraph::Edges::kAll));
  }
  return touched;
}

// Start poses: if no known step connects the two sides of the loop, the side that began later is moved as a whole.
std::map<KeyframeId, SE3> Joined(const Map& map, const LoopEdge& loop, const MapGraph& graph) {
  std::map<KeyframeId, SE3> T_w_kf;
  for (const KeyframeId id : Touched(loop, graph)) T_w_kf[id] = map.FindKeyframe(id)->T_w_kf;
  const std::set<KeyframeId> old_side = graph.Component(loop.old_keyframe_id, MapGraph::Edges::kKnown);
  if (old_side.contains(loop.keyframe_id)) return T_w_kf;
  const std::set<KeyframeId> new_side = graph.Component(loop.keyframe_id, MapGraph::Edges::kKnown);
  const SE3 T_moved_w = T_w_kf.at(loop.old_keyframe_id) * loop.T_old_kf * T_w_kf.at(loop.keyframe_id).Inverse();
  const bool old_first = *old_side.begin() < *new_side.begin();
  for (const KeyframeId id : old_first ? new_side : old_side) {
    T_w_kf[id] = (old_first ? T_moved_w : T_moved_w.Inverse()) * T_w_kf[id];
  }
  return T_w_kf;
}

MapPoseGraph MakeLoopGraph(const Map& map, const LoopEdge& loop, const CorrectionOptions& options) {
  const MapGraph graph(map);
  MapPoseGraph loop_graph = PoseGraphOf(map, graph, Joined(map, loop, graph), options.drift);
  if (const auto information = InformationFromCovariance(loop.covariance)) {
    loop_graph.problem.edges.push_back({loop_graph.IndexOf(loop.old_keyframe_id),
                                        loop_graph.IndexOf(loop.keyframe_id), loop.T_old_kf, *information, true});
  }
  return loop_graph;
}

}  // namespace

std::optional<std::vector<CorrectedPose>> CloseLoop(const Map& map, const LoopEdge& loop,
                                                    const CorrectionOptions& options) {
  const auto [keyframe_ids, problem] = MakeLoopGraph(map, loop, options);
  if (problem.edges.empty() || !problem.edges.back().robust) return std::nullopt;
  const PoseGraphResult result = OptimisePoseGraph(problem, options.graph);
  if (!result.ok || result.rejected.back()) return std::nullopt;
  std::vector<CorrectedPose> poses;
  for (size_t i = 0; i < keyframe_ids.size(); ++i) poses.push_back({keyframe_ids[i], result.T_w_kf[i]});
  return poses;
}

}  // namespace plslam::loop
