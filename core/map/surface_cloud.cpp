// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/surface_cloud.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

namespace plslam {
namespace {

constexpr float kNormalUnits = 127.0F;

/// Cubes by 21 bits for each axis.
uint64_t KeyOf(const Eigen::Vector3i& cube) {
  uint64_t key = 0;
  for (int i = 0; i < 3; ++i) key = key << 21 | (static_cast<uint64_t>(static_cast<int64_t>(cube[i])) & 0x1FFFFF);
  return key;
}

Eigen::Vector3i CubeOf(const SurfacePoint& point, double voxel_m) {
  return (point.p.cast<double>() / voxel_m).array().floor().cast<int>();
}

/// Counts the points that are far from all points of `others`, up to `most`.
size_t CountFar(const std::vector<SurfacePoint>& points, const std::vector<SurfacePoint>& others, double voxel_m,
                size_t most) {
  std::unordered_set<uint64_t> cubes;
  cubes.reserve(others.size());
  for (const SurfacePoint& other : others) cubes.insert(KeyOf(CubeOf(other, voxel_m)));
  const auto is_near = [&](const SurfacePoint& point) {
    const Eigen::Vector3i cube = CubeOf(point, voxel_m);
    // The point's own cube first: most have one there.
    if (cubes.contains(KeyOf(cube))) return true;
    for (int i = 0; i < 27; ++i) {
      if (cubes.contains(KeyOf(cube + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)))) return true;
    }
    return false;
  };
  size_t n = 0;
  for (const SurfacePoint& point : points) {
    if (!is_near(point) && ++n >= most) break;
  }
  return n;
}

}  // namespace

std::array<int8_t, 3> RoundedNormal(const Eigen::Vector3f& normal) {
  std::array<int8_t, 3> rounded{};
  for (int i = 0; i < 3; ++i) {
    rounded[i] = static_cast<int8_t>(std::lround(std::clamp(normal[i], -1.0F, 1.0F) * kNormalUnits));
  }
  return rounded;
}

Eigen::Vector3f UnitNormal(const SurfacePoint& point) {
  return Eigen::Vector3f(point.normal[0], point.normal[1], point.normal[2]).normalized();
}

SurfacePoint Moved(const SE3& T_a_b, const SurfacePoint& point_b) {
  return {(T_a_b * point_b.p.cast<double>()).cast<float>(),
          RoundedNormal((T_a_b.R() * UnitNormal(point_b).cast<double>()).cast<float>()), point_b.grey};
}

size_t SurfaceCloud::n_points() const {
  size_t n = 0;
  for (const auto& [number, submap] : submaps) n += submap.points.size();
  return n;
}

std::vector<SurfacePoint> SurfaceCloud::PointsInW() const {
  std::vector<SurfacePoint> points;
  points.reserve(n_points());
  for (const auto& [number, submap] : submaps) {
    for (const SurfacePoint& point : submap.points) points.push_back(Moved(submap.T_w_anchor, point));
  }
  return points;
}

bool HasOtherSurfaces(const std::vector<SurfacePoint>& before, const std::vector<SurfacePoint>& now, double voxel_m,
                      size_t least_points) {
  return CountFar(now, before, voxel_m, least_points) >= least_points ||
         CountFar(before, now, voxel_m, least_points) >= least_points;
}

}  // namespace plslam
