// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam::test {

/// A trajectory in laps with edges to the neighbours and to earlier laps, drawn from the information they carry.
struct PoseGraphSpec {
  int poses = 60;
  int lap = 20;
  /// Edges of a pose to the ones before it.
  int reach = 2;
  /// Standard deviations of all edges.
  double sigma_m = 0.02;
  double sigma_rad = 0.005;
  uint64_t seed = 1;
};

template <class Pose>
struct PoseGraphWorld {
  std::vector<Pose> truth;
  /// Starts from chained odometry. Edges to earlier laps are robust.
  PoseGraph<Pose> graph;
};

template <class Pose>
PoseGraphWorld<Pose> MakePoseGraphWorld(const PoseGraphSpec& spec);

/// An edge from a to b with the spec's information and the motion given.
template <class Pose>
PoseGraphMotion<Pose> MakeEdge(const PoseGraphSpec& spec, int a, int b, const Pose& T_a_b, bool robust);

/// Greatest distance between positions.
template <class Pose>
double LargestError_m(const std::vector<Pose>& a, const std::vector<Pose>& b);

}  // namespace plslam::test
