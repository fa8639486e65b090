// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pose_graph/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "core/optim/pose_graph/map_pose_graph.h"

namespace plslam::pose_graph {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;

SE3 InSpace(const SE3& pose) { return pose; }
SE3 InSpace(const SE2& pose) {
  return SE3(Eigen::Quaterniond(Eigen::AngleAxisd(pose.angle(), Eigen::Vector3d::UnitZ())),
             {pose.translation().x(), pose.translation().y(), 0.0});
}

template <class Pose>
Trajectory Convert(const G2oGraph<Pose>& graph) {
  Trajectory trajectory;
  for (size_t i = 0; i < graph.ids.size(); ++i) {
    // Numbers too large for seconds are used as nanoseconds: only their order matters.
    const bool fits = graph.ids.back() < std::numeric_limits<int64_t>::max() / kSecond_ns;
    trajectory.push_back({graph.ids[i] * (fits ? kSecond_ns : 1), InSpace(graph.graph.poses[i].T_w_kf)});
  }
  return trajectory;
}

}  // namespace

Trajectory TrajectoryOf(const G2oGraph<SE3>& graph) { return Convert(graph); }
Trajectory TrajectoryOf(const G2oGraph<SE2>& graph) { return Convert(graph); }

std::vector<SessionTrajectory> TrajectoriesOf(const Map& map) {
  std::vector<SessionTrajectory> sessions;
  std::map<SessionId, size_t> place_of;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const auto [place, is_new] = place_of.try_emplace(keyframe.name.session, sessions.size());
    if (is_new) sessions.push_back({sessions.empty() ? "" : fmt::format("_s{}", keyframe.name.session), {}});
    sessions[place->second].keyframes.push_back({keyframe.t_ns, keyframe.T_w_kf});
  }
  const auto earlier = [](const TrajectoryPose& a, const TrajectoryPose& b) { return a.t_ns < b.t_ns; };
  const auto same = [](const TrajectoryPose& a, const TrajectoryPose& b) { return a.t_ns == b.t_ns; };
  for (auto& [suffix, keyframes] : sessions) {
    std::stable_sort(keyframes.begin(), keyframes.end(), earlier);
    keyframes.erase(std::unique(keyframes.begin(), keyframes.end(), same), keyframes.end());
  }
  return sessions;
}

G2oGraph<SE3> G2oOf(const Map& map) {
  MapPoseGraph of_map = PoseGraphOf(map);
  const size_t n = of_map.keyframe_ids.size();
  return {Values(of_map.keyframe_ids), std::move(of_map.problem), std::vector<bool>(n, true)};
}

}  // namespace plslam::pose_graph
