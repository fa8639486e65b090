// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/optim/pose_graph_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/optim/pose_graph/pose_graph_group.h"

namespace plslam::test {
namespace {

template <class Pose>
Pose TruePose(const PoseGraphSpec& spec, int i);

template <>
SE2 TruePose<SE2>(const PoseGraphSpec& spec, int i) {
  const double phase = 2.0 * std::numbers::pi * i / spec.lap;
  const double radius = 5.0 + 0.3 * std::sin(0.7 * i);
  return SE2(WrapAngle(phase + 0.5 * std::numbers::pi),
             Eigen::Vector2d(radius * std::cos(phase), radius * std::sin(phase)));
}

template <>
SE3 TruePose<SE3>(const PoseGraphSpec& spec, int i) {
  const SE2 flat = TruePose<SE2>(spec, i);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(flat.angle(), Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d tilt(0.3 * std::sin(0.4 * i), 0.2 * std::cos(0.3 * i), 0.0);
  return SE3(turn * ExpSO3(tilt), {flat.translation().x(), flat.translation().y(), 0.5 * std::sin(0.2 * i)});
}

}  // namespace

template <class Pose>
PoseGraphMotion<Pose> MakeEdge(const PoseGraphSpec& spec, int a, int b, const Pose& T_a_b, bool robust) {
  PoseGraphMotion<Pose> edge;
  edge.a = a;
  edge.b = b;
  edge.T_a_b = T_a_b;
  edge.robust = robust;
  constexpr int kDimension = PoseGroup<Pose>::kDimension;
  edge.information.setIdentity();
  edge.information.diagonal().template head<kDimension>().setConstant(1.0 / (spec.sigma_m * spec.sigma_m));
  edge.information.diagonal().template tail<kPoseFreedom<Pose> - kDimension>().setConstant(
      1.0 / (spec.sigma_rad * spec.sigma_rad));
  return edge;
}

template <class Pose>
PoseGraphWorld<Pose> MakePoseGraphWorld(const PoseGraphSpec& spec) {
  std::mt19937_64 random(spec.seed);
  std::normal_distribution<double> normal;
  PoseGraphWorld<Pose> world;
  for (int i = 0; i < spec.poses; ++i) world.truth.push_back(TruePose<Pose>(spec, i));
  const auto add = [&](int a, int b, bool robust) {
    Eigen::Matrix<double, kPoseFreedom<Pose>, 1> noise;
    for (int k = 0; k < noise.size(); ++k) {
      noise[k] = normal(random) * (k < PoseGroup<Pose>::kDimension ? spec.sigma_m : spec.sigma_rad);
    }
    const Pose T_a_b = PoseGroup<Pose>::Plus(world.truth[a].Inverse() * world.truth[b], noise.data());
    world.graph.edges.push_back(MakeEdge(spec, a, b, T_a_b, robust));
  };
  world.graph.poses.push_back({world.truth[0], true});
  for (int b = 1; b < spec.poses; ++b) {
    add(b - 1, b, false);
    world.graph.poses.push_back({world.graph.poses.back().T_w_kf * world.graph.edges.back().T_a_b, false});
    for (int step = 2; step <= std::min(spec.reach, b); ++step) add(b - step, b, false);
    if (b >= spec.lap && b % 5 == 0) add(b - spec.lap, b, true);
  }
  return world;
}

template <class Pose>
double LargestError_m(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  double largest = 0.0;
  for (size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, (a[i].translation() - b[i].translation()).norm());
  }
  return largest;
}

template PoseGraphWorld<SE3> MakePoseGraphWorld(const PoseGraphSpec&);
template PoseGraphWorld<SE2> MakePoseGraphWorld(const PoseGraphSpec&);
template PoseGraphMotion<SE3> MakeEdge(const PoseGraphSpec&, int, int, const SE3&, bool);
template PoseGraphMotion<SE2> MakeEdge(const PoseGraphSpec&, int, int, const SE2&, bool);
template double LargestError_m(const std::vector<SE3>&, const std::vector<SE3>&);
template double LargestError_m(const std::vector<SE2>&, const std::vector<SE2>&);

}  // namespace plslam::test
