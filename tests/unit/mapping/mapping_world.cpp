// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/mapping/mapping_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "core/bus/messages/map_pages.h"
#include "plslam/map_update_t.hpp"

namespace plslam::test {
namespace {

using Ids = std::map<Descriptor, TrackId>;

template <class Landmark>
Ids IdsOf(const std::vector<Landmark>& landmarks) {
  Ids ids;
  for (const Landmark& landmark : landmarks) ids.emplace(landmark.descriptor, TrackId(ids.size()));
  return ids;
}

template <class Feature>
std::vector<TrackId> IdsOfFeatures(const std::vector<Feature>& features, const Ids& ids) {
  std::vector<TrackId> of;
  for (const Feature& feature : features) of.push_back(ids.at(feature.left.descriptor));
  return of;
}

Matrix6d MotionCovariance(const WalkOptions& options) {
  Vector6d variances;
  variances.head<3>().setConstant(options.motion_sigma_m * options.motion_sigma_m);
  variances.tail<3>().setConstant(options.motion_sigma_rad * options.motion_sigma_rad);
  return variances.asDiagonal();
}

std::string WrongCovariance(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return "covariance is not finite";
  if (covariance.diagonal().minCoeff() < 0.0) return "covariance has a negative variance";
  return {};
}

std::string WrongWith(const MapKeyframe& keyframe, const Map& map) {
  if (!keyframe.T_w_kf.IsFinite() || !keyframe.T_prevkf_kf.IsFinite()) return "pose is not finite";
  if (!keyframe.covariance.allFinite() || !keyframe.relative_covariance.allFinite())
    return "covariance is not finite";
  if (keyframe.covariance.diagonal().minCoeff() < 0.0) return "covariance has a negative variance";
  if (keyframe.parent_id >= keyframe.id) return fmt::format("parent {} is not older", keyframe.parent_id);
  if (keyframe.parent_id >= 0 && map.FindKeyframe(keyframe.parent_id) == nullptr) return "parent is not in the map";
  if (keyframe.previous_id >= 0 && map.FindKeyframe(keyframe.previous_id) == nullptr) return "previous is not there";
  return {};
}

std::string WrongWith(const MapPoint& point) {
  if (!point.p_w.allFinite()) return "position is not finite";
  if (!(point.depth_m > 0.0) || !std::isfinite(point.depth_m)) return fmt::format("depth is {}", point.depth_m);
  return WrongCovariance(point.covariance);
}

std::string WrongWith(const MapLine& line) {
  if (!line.segment_w.p.allFinite() || !line.segment_w.q.allFinite()) return "an end is not finite";
  if (!((line.segment_w.q - line.segment_w.p).norm() > 0.0)) return "no length";
  const std::string of_p = WrongCovariance(line.covariance_p);
  return of_p.empty() ? WrongCovariance(line.covariance_q) : of_p;
}

template <class Type>
std::string WrongObservations(const typename Type::Landmark& landmark, const Map& map) {
  if (landmark.observations.empty()) return "no observations";
  for (const Observation& observation : landmark.observations) {
    if (map.FindKeyframe(observation.keyframe_id()) == nullptr)
      return fmt::format("observation of no keyframe {}", observation.keyframe_id());
    const LandmarkId shown = LandmarkAt<Type>(map, observation);
    if (shown != landmark.id) return fmt::format("its observation in {} shows {}", observation.keyframe_id(), shown);
  }
  return {};
}

template <class Type>
std::string WrongLandmarks(const char* name, const Map& map) {
  for (const auto& [id, landmark] : Type::Landmarks(map)) {
    std::string wrong = WrongWith(landmark);
    if (wrong.empty()) wrong = WrongObservations<Type>(landmark, map);
    if (!wrong.empty()) return fmt::format("{} {}: {}", name, id, wrong);
  }
  return {};
}

SE3 CameraAt(const Eigen::Vector3d& p_w, double yaw_rad) { return {ExpSO3(Eigen::Vector3d(0.0, yaw_rad, 0.0)), p_w}; }

}  // namespace

Descriptor DescriptorOf(uint64_t seed) {
  std::mt19937_64 generator(seed);
  return {generator(), generator(), generator(), generator()};
}

Keyframe MakeKeyframe(const Keyframe* previous, const SE3& T_odom_kf, StereoFeatures features) {
  Keyframe keyframe;
  keyframe.camera = FeatureWorld::Camera();
  keyframe.name.session = previous == nullptr ? 7 : previous->name.session;
  keyframe.T_odom_kf = T_odom_kf;
  keyframe.SetFeatures(std::move(features));
  if (previous == nullptr) return keyframe;
  keyframe.name.number = previous->name.number + 1;
  keyframe.previous_keyframe_id = previous->name.number;
  keyframe.frame_id = FrameId(previous->frame_id.value + 5);
  keyframe.t_ns = previous->t_ns + 250'000'000;
  keyframe.T_prevkf_kf = previous->T_odom_kf.Inverse() * T_odom_kf;
  keyframe.covariance = MotionCovariance({});
  return keyframe;
}

Walk MakeWalk(const FeatureWorld& world, const std::vector<SE3>& path, const WalkOptions& options) {
  const Ids point_ids = IdsOf(world.points());
  const Ids line_ids = IdsOf(world.lines());
  std::mt19937_64 generator(options.seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    const double x = normal(generator);
    const double y = normal(generator);
    const double z = normal(generator);
    return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
  };
  Walk walk;
  walk.T_w_c = path;
  for (size_t i = 0; i < path.size(); ++i) {
    SE3 T_odom_kf = path[i];
    if (i > 0) {
      Vector6d error;
      error << noise(options.motion_sigma_m), noise(options.motion_sigma_rad);
      T_odom_kf = walk.keyframes.back().T_odom_kf * path[i - 1].Inverse() * path[i] * SE3::Exp(error);
    }
    Keyframe keyframe = MakeKeyframe(i == 0 ? nullptr : &walk.keyframes.back(), T_odom_kf,
                                     world.Observe(path[i], options.noise_px, 1000 * options.seed + i));
    keyframe.name.session = options.session;
    if (i > 0) keyframe.covariance = MotionCovariance(options);
    if (options.with_ids) {
      keyframe.point_landmark_ids = IdsOfFeatures(keyframe.features.points, point_ids);
      keyframe.line_landmark_ids = IdsOfFeatures(keyframe.features.lines, line_ids);
    }
    walk.keyframes.push_back(std::move(keyframe));
  }
  return walk;
}

std::vector<SE3> TurningPath(int n) {
  std::vector<SE3> path;
  for (int i = 0; i < n; ++i) {
    const double s = 0.05 * i;
    path.push_back(CameraAt({0.9 * std::sin(s), 0.15 * std::sin(2.0 * s), 0.9 * (1.0 - std::cos(s))}, 0.7 * s));
  }
  return path;
}

FeatureWorld MakeCorridor(double length_m, double points_per_m, double lines_per_m, uint64_t seed) {
  constexpr double kHalfWidth_m = 1.5;
  std::mt19937_64 generator(seed);
  const auto between = [&generator](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(generator);
  };
  const auto on_wall = [&](double z) {
    const double side = between(-1.0, 1.0) < 0.0 ? -kHalfWidth_m : kHalfWidth_m;
    const double y = between(-1.2, 1.2);
    return Eigen::Vector3d(side + between(-0.3, 0.3), y, z);
  };
  std::vector<FeatureWorld::Point> points;
  std::vector<FeatureWorld::Line> lines;
  const int n_points = static_cast<int>(length_m * points_per_m);
  for (int i = 0; i < n_points; ++i) points.push_back({on_wall(i / points_per_m), DescriptorOf(generator())});
  const int n_lines = static_cast<int>(length_m * lines_per_m);
  for (int i = 0; i < n_lines; ++i) {
    const Eigen::Vector3d p = on_wall(i / lines_per_m);
    const Eigen::Vector3d along =
        i % 3 == 0 ? Eigen::Vector3d(0.0, 0.0, 1.0) : Eigen::Vector3d(0.0, p.y() > 0.0 ? -1.0 : 1.0, 0.0);
    lines.push_back({{p, p + along}, DescriptorOf(generator())});
  }
  return {std::move(points), std::move(lines), 8.0};
}

std::vector<SE3> CorridorPath(int n, double step_m) {
  std::vector<SE3> path;
  for (int i = 0; i < n; ++i) {
    path.push_back(
        CameraAt({0.2 * std::sin(0.1 * i), 0.05 * std::sin(0.3 * i), step_m * i}, 0.05 * std::sin(0.13 * i)));
  }
  return path;
}

bool MapOne(const Keyframe& keyframe, mapping::Mapper& mapper, std::string* reason) {
  std::string ignored;
  if (!mapper.Insert(keyframe, reason == nullptr ? &ignored : reason)) return false;
  mapper.Adjust(nullptr);
  mapper.Cull();
  return true;
}

mapping::Mapper MapAll(const std::vector<Keyframe>& keyframes, const mapping::MappingOptions& options) {
  mapping::Mapper mapper(FeatureWorld::Camera(), options);
  for (const Keyframe& keyframe : keyframes) MapOne(keyframe, mapper);
  return mapper;
}

std::string WrongWith(const Map& map) {
  for (const auto& [id, keyframe] : map.keyframes()) {
    const std::string wrong = WrongWith(keyframe, map);
    if (!wrong.empty()) return fmt::format("keyframe {}: {}", id, wrong);
  }
  const std::string points = WrongLandmarks<PointType>("point", map);
  return points.empty() ? WrongLandmarks<LineType>("line", map) : points;
}

int ExactlyKnown(const Map& map) {
  const auto point = [](const auto& item) { return !(item.second.covariance.matrix().trace() > 0.0); };
  const auto line = [](const auto& item) {
    return !(item.second.covariance_p.matrix().trace() > 0.0 && item.second.covariance_q.matrix().trace() > 0.0);
  };
  return static_cast<int>(std::count_if(map.points().begin(), map.points().end(), point) +
                          std::count_if(map.lines().begin(), map.lines().end(), line));
}

std::vector<uint8_t> Encoded(const MapUpdate& update) {
  std::vector<uint8_t> all;
  for (const map_update_t& page : bus::CutIntoPages(update, 60'000)) {
    const size_t begin = all.size();
    all.resize(begin + static_cast<size_t>(page.getEncodedSize()));
    page.encode(all.data(), static_cast<int>(begin), page.getEncodedSize());
  }
  return all;
}

std::vector<uint8_t> Encoded(const Map& map) {
  MapUpdate update = WholeMap(map);
  update.version = 1;
  return Encoded(update);
}

double PositionError_m(const Map& map, const std::vector<SE3>& T_w_c) {
  double sum = 0.0;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const SE3& truth = T_w_c.at(static_cast<size_t>(keyframe.name.number));
    sum += (keyframe.T_w_kf.translation() - truth.translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(map.keyframes().size()));
}

double OdometryError_m(const Walk& walk) {
  double sum = 0.0;
  for (size_t i = 0; i < walk.T_w_c.size(); ++i) {
    sum += (walk.keyframes[i].T_odom_kf.translation() - walk.T_w_c[i].translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(walk.T_w_c.size()));
}

std::vector<double> PointErrors_m(const Map& map, const FeatureWorld& world) {
  const Ids ids = IdsOf(world.points());
  std::vector<double> errors;
  for (const auto& [id, point] : map.points()) {
    const auto& truth = world.points()[static_cast<size_t>(ids.at(point.descriptor).value)];
    errors.push_back((point.p_w - truth.p_w).norm());
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

std::vector<double> LineErrors_m(const Map& map, const FeatureWorld& world) {
  const Ids ids = IdsOf(world.lines());
  std::vector<double> errors;
  for (const auto& [id, line] : map.lines()) {
    const Segment3& truth = world.lines()[static_cast<size_t>(ids.at(line.descriptor).value)].segment_w;
    const Eigen::Vector3d along = (truth.q - truth.p).normalized();
    const double of_p = along.cross(line.segment_w.p - truth.p).norm();
    const double of_q = along.cross(line.segment_w.q - truth.p).norm();
    errors.push_back(std::max(of_p, of_q));
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

}  // namespace plslam::test
