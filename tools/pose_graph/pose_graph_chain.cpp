// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pose_graph/pose_graph_chain.h"

#include <cstdlib>

#include "core/optim/pose_graph/pose_graph_blocks.h"

namespace plslam::pose_graph {
namespace {

/// Edges of a spanning forest, by pose.
template <class Pose>
std::vector<std::vector<int>> SpanningForest(const PoseGraph<Pose>& graph) {
  std::vector<std::vector<int>> edges_of(graph.poses.size());
  GraphParts parts(graph.poses.size());
  for (const bool odometry : {true, false}) {
    for (size_t i = 0; i < graph.edges.size(); ++i) {
      const PoseGraphMotion<Pose>& edge = graph.edges[i];
      if ((std::abs(edge.a - edge.b) == 1) != odometry || !parts.Join(edge.a, edge.b)) continue;
      edges_of[edge.a].push_back(static_cast<int>(i));
      edges_of[edge.b].push_back(static_cast<int>(i));
    }
  }
  return edges_of;
}

template <class Pose>
class Chain {
 public:
  explicit Chain(const PoseGraph<Pose>& graph) : graph_(graph), edges_of_(SpanningForest(graph)) {}

  /// Chains poses along the tree from `root`, as far as they are unknown.
  void Spread(int root, std::vector<bool>& known, std::vector<Pose>& poses) const {
    std::vector<int> front = {root};
    while (!front.empty()) {
      const int from = front.back();
      front.pop_back();
      for (const int i : edges_of_[from]) {
        const PoseGraphMotion<Pose>& edge = graph_.edges[i];
        const int to = edge.a == from ? edge.b : edge.a;
        if (known[to]) continue;
        poses[to] = poses[from] * (edge.a == from ? edge.T_a_b : edge.T_a_b.Inverse());
        known[to] = true;
        front.push_back(to);
      }
    }
  }

 private:
  const PoseGraph<Pose>& graph_;
  std::vector<std::vector<int>> edges_of_;
};

}  // namespace

template <class Pose>
std::vector<Pose> ChainedPoses(const PoseGraph<Pose>& graph, std::vector<bool> known) {
  std::vector<Pose> poses;
  for (const PoseGraphNode<Pose>& node : graph.poses) poses.push_back(node.T_w_kf);
  if (known.empty()) {
    for (const PoseGraphNode<Pose>& node : graph.poses) known.push_back(node.fixed);
  }
  const Chain<Pose> chain(graph);
  const std::vector<bool> roots = known;
  for (size_t i = 0; i < poses.size(); ++i) {
    if (roots[i]) chain.Spread(static_cast<int>(i), known, poses);
  }
  for (size_t i = 0; i < poses.size(); ++i) {
    if (known[i]) continue;
    known[i] = true;
    chain.Spread(static_cast<int>(i), known, poses);
  }
  return poses;
}

template std::vector<SE3> ChainedPoses(const PoseGraph<SE3>&, std::vector<bool>);
template std::vector<SE2> ChainedPoses(const PoseGraph<SE2>&, std::vector<bool>);

}  // namespace plslam::pose_graph
