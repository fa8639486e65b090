// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/ids/ids.h"

namespace plslam {

/// A point of a surface, as messages carry it.
struct SurfacePoint {
  Eigen::Vector3f p = Eigen::Vector3f::Zero();
  std::array<int8_t, 3> normal{};  ///< unit length times 127, towards free space
  uint8_t grey = 0;

  bool operator==(const SurfacePoint&) const = default;
};

/// Rounds a unit normal.
std::array<int8_t, 3> RoundedNormal(const Eigen::Vector3f& normal);
Eigen::Vector3f UnitNormal(const SurfacePoint& point);

/// Returns the point in another frame `a`.
SurfacePoint Moved(const SE3& T_a_b, const SurfacePoint& point_b);

/// Surface points of a submap, in the frame of the keyframe to which it is anchored.
struct SubmapCloud {
  SessionId anchor_session;
  FrameId anchor_frame_id;
  SE3 T_w_anchor;
  std::vector<SurfacePoint> points;
};

/// The surfaces of a map as points, in submaps that a correction of the map moves rigidly.
struct SurfaceCloud {
  double voxel_m = 0.0;                ///< distance of neighbouring points
  std::map<int, SubmapCloud> submaps;  ///< by number

  size_t n_points() const;
  /// Returns all points in w, submap by submap.
  std::vector<SurfacePoint> PointsInW() const;
};

/// Returns whether so many points of one list have no point of the other in their own or a neighbouring cube of
/// `voxel_m`: a surface has appeared or disappeared, and not just become more precise.
bool HasOtherSurfaces(const std::vector<SurfacePoint>& before, const std::vector<SurfacePoint>& now, double voxel_m,
                      size_t least_points);

}  // namespace plslam
