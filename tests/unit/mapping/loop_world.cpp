// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/mapping/loop_world.h"

#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <utility>

#include <Eigen/Cholesky>

#include "loop_process/keyframe_memory.h"

namespace plslam::test {
namespace {

constexpr double kHalfWidth_m = 1.5;
constexpr double kView_m = 7.0;

SE3 OnRing(double radius_m, double angle_rad) {
  // Around y, from the origin on, looking along z at first.
  return {ExpSO3(Eigen::Vector3d(0.0, angle_rad, 0.0)),
          {radius_m * (1.0 - std::cos(angle_rad)), 0.0, radius_m * std::sin(angle_rad)}};
}

const SE3& Truth(const MapKeyframe& keyframe, const std::vector<SE3>& T_w_c) {
  return T_w_c.at(static_cast<size_t>(keyframe.name.number));
}

template <class Type>
std::vector<SameLandmarks> SameSeen(const Map& map, const Revisit& revisit) {
  std::map<Descriptor, LandmarkId> seen;
  for (const LandmarkId id : Type::Of(map, revisit.old_keyframe_id)) {
    if (id >= 0) seen[Type::Find(map, id)->descriptor] = id;
  }
  std::vector<SameLandmarks> same;
  for (const LandmarkId id : Type::Of(map, revisit.keyframe_id)) {
    if (id < 0) continue;
    const auto known = seen.find(Type::Find(map, id)->descriptor);
    if (known != seen.end() && known->second != id) same.push_back({known->second, id});
  }
  return same;
}

template <class Type>
int DuplicatesOf(const Map& map) {
  std::set<Descriptor> known;
  int duplicates = 0;
  for (const auto& [id, landmark] : Type::Landmarks(map)) duplicates += !known.insert(landmark.descriptor).second;
  return duplicates;
}

// One metre weighs as much as half a radian.
const Vector6d kShare = (Vector6d() << 1.0, 1.0, 1.0, 0.25, 0.25, 0.25).finished();

// Changes the steps by the least amounts that together close the loop: those are w_i K A_i^T (sum w_j A_j K A_j^T)^-1
// x, where A_i takes a change of step i to the end, w_i is its length in keyframes, and x is the error there.
std::vector<CorrectedPose> SharedOut(const Map& map, const LoopEdge& edge) {
  std::vector<CorrectedPose> poses;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id >= edge.old_keyframe_id && id <= edge.keyframe_id) poses.push_back({id, keyframe.T_w_kf});
  }
  const SE3 T_w_end = poses.front().T_w_kf * edge.T_old_kf;
  for (int iteration = 0; iteration < 5; ++iteration) {
    const SE3 T_end_w = poses.back().T_w_kf.Inverse();
    const Vector6d missing = (T_end_w * T_w_end).Log();
    Matrix6d sum = Matrix6d::Zero();
    std::vector<Matrix6d> K_At;
    for (size_t i = 0; i < poses.size(); ++i) {
      const Matrix6d A = (T_end_w * poses[i].T_w_kf).Adjoint();
      const int64_t length = i == 0 ? 0 : poses[i].keyframe_id.value - poses[i - 1].keyframe_id.value;
      K_At.emplace_back(static_cast<double>(length) * kShare.asDiagonal() * A.transpose());
      sum += A * K_At.back();
    }
    const Vector6d weighted = sum.ldlt().solve(missing);
    std::vector<CorrectedPose> next = poses;
    for (size_t i = 1; i < poses.size(); ++i) {
      const SE3 T_before_kf = poses[i - 1].T_w_kf.Inverse() * poses[i].T_w_kf;
      next[i].T_w_kf = next[i - 1].T_w_kf * T_before_kf * SE3::Exp(K_At[i] * weighted);
    }
    poses = next;
  }
  return poses;
}

template <class Type>
std::vector<LandmarkId> MapIds(const Map& map, SessionId session, const StereoFeatures& features) {
  std::map<Descriptor, LandmarkId> known;
  for (const auto& [id, landmark] : Type::Landmarks(map)) {
    if (map.FindKeyframe(landmark.observations.front().keyframe_id())->name.session == session)
      known[landmark.descriptor] = id;
  }
  std::vector<LandmarkId> ids;
  for (const auto& feature : Type::Features(features)) {
    const auto found = known.find(feature.left.descriptor);
    ids.push_back(found == known.end() ? -1 : found->second);
  }
  return ids;
}

}  // namespace

void GiveMapIds(const Map& map, SessionId session, Keyframe& keyframe) {
  keyframe.point_map_ids = MapIds<PointType>(map, session, keyframe.features);
  keyframe.line_map_ids = MapIds<LineType>(map, session, keyframe.features);
}

LoopClosure Drift(const Map& map) {
  const Vector6d wrong = (Vector6d() << 4e-4, 4e-4, 4e-4, 2e-4, 1.3e-3, 2e-4).finished();
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kAdjustment;
  for (const auto& [id, keyframe] : map.keyframes()) {
    SE3 T_w_kf = keyframe.T_w_kf;
    if (!closure.poses.empty()) {
      const CorrectedPose& before = closure.poses.back();
      const SE3 T_before_kf = map.FindKeyframe(before.keyframe_id)->T_w_kf.Inverse() * T_w_kf;
      T_w_kf =
          before.T_w_kf * T_before_kf * SE3::Exp(static_cast<double>(id.value - before.keyframe_id.value) * wrong);
    }
    closure.poses.push_back({id, T_w_kf});
  }
  return closure;
}

FeatureWorld MakeRing(double radius_m, int points, int lines, uint64_t seed) {
  std::mt19937_64 generator(seed);
  const auto between = [&generator](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(generator);
  };
  const auto on_wall = [&](double angle_rad) {
    const double side_m = between(-1.0, 1.0) < 0.0 ? -kHalfWidth_m : kHalfWidth_m;
    const double y_m = between(-1.2, 1.2);
    return OnRing(radius_m, angle_rad) * Eigen::Vector3d(side_m + between(-0.3, 0.3), y_m, 0.0);
  };
  std::vector<FeatureWorld::Point> of_points;
  std::vector<FeatureWorld::Line> of_lines;
  for (int i = 0; i < points; ++i) {
    const Eigen::Vector3d p_w = on_wall(2.0 * std::numbers::pi * i / points);
    of_points.push_back({p_w, DescriptorOf(generator())});
  }
  for (int i = 0; i < lines; ++i) {
    const Eigen::Vector3d p_w = on_wall(2.0 * std::numbers::pi * i / lines);
    const Eigen::Vector3d along = p_w.y() > 0.0 ? Eigen::Vector3d(0.1, -1.0, 0.1) : Eigen::Vector3d(-0.1, 1.0, 0.1);
    of_lines.push_back({{p_w, p_w + along}, DescriptorOf(generator())});
  }
  return {std::move(of_points), std::move(of_lines), kView_m};
}

std::vector<SE3> RingPath(double radius_m, double step_m, int n) {
  std::vector<SE3> path;
  for (int i = 0; i < n; ++i) {
    const SE3 aside{ExpSO3(Eigen::Vector3d(0.02 * std::sin(0.5 * i), 0.0, 0.0)), {0.1 * std::sin(0.3 * i), 0.0, 0.0}};
    path.push_back(OnRing(radius_m, i * step_m / radius_m) * aside);
  }
  return path;
}

Revisit RevisitOf(const Map& map, const std::vector<SE3>& T_w_c) {
  const MapKeyframe& newest = map.keyframes().rbegin()->second;
  Revisit revisit{-1, newest.id};
  double nearest_m = 1e9;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (2 * id.value > newest.id.value) break;
    const SE3 T_old_new = Truth(keyframe, T_w_c).Inverse() * Truth(newest, T_w_c);
    if (T_old_new.translation().norm() >= nearest_m) continue;
    nearest_m = T_old_new.translation().norm();
    revisit.old_keyframe_id = id;
  }
  return revisit;
}

LoopClosure CloseByTruth(const Map& map, const Revisit& revisit, const std::vector<SE3>& T_w_c) {
  const MapKeyframe& old_end = *map.FindKeyframe(revisit.old_keyframe_id);
  const MapKeyframe& new_end = *map.FindKeyframe(revisit.keyframe_id);
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kLoop;
  closure.keyframe = new_end.name;
  LoopEdge edge{old_end.id, new_end.id, Truth(old_end, T_w_c).Inverse() * Truth(new_end, T_w_c)};
  edge.covariance = 1e-4 * Matrix6d::Identity();
  closure.edges.push_back(edge);
  closure.poses = SharedOut(map, edge);
  closure.points = SameSeen<PointType>(map, revisit);
  closure.lines = SameSeen<LineType>(map, revisit);
  closure.names = loop::NamesIn(map, closure);
  return closure;
}

LoopClosure AdjustByTruth(const Map& map, const std::vector<SE3>& T_w_c) {
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kAdjustment;
  for (const auto& [id, keyframe] : map.keyframes()) closure.poses.push_back({id, Truth(keyframe, T_w_c)});
  return closure;
}

int Duplicates(const Map& map) { return DuplicatesOf<PointType>(map) + DuplicatesOf<LineType>(map); }

double Reprojection_px(const Map& map, const std::vector<Keyframe>& keyframes) {
  const StereoCamera camera = FeatureWorld::Camera();
  double sum = 0.0;
  for (const auto& [id, point] : map.points()) {
    for (const Observation& observation : point.observations) {
      const MapKeyframe& keyframe = *map.FindKeyframe(observation.keyframe_id());
      const auto& seen = keyframes.at(static_cast<size_t>(keyframe.name.number)).features.points;
      const Eigen::Vector2d px = camera.Project(keyframe.T_w_kf.Inverse() * point.p_w);
      sum += (px - seen.at(static_cast<size_t>(observation.feature)).left.px).squaredNorm();
    }
  }
  return std::sqrt(sum / static_cast<double>(std::max<int64_t>(1, map.Totals().point_observations)));
}

}  // namespace plslam::test
