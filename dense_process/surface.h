// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "dense_process/volume.h"

namespace plslam::dense {

/// A voxel that fewer rays of full weight have crossed is not known well enough for a surface, an obstacle or free
/// space.
inline constexpr float kLeastKnown = 1.0F;

/// A surface as triangles, in the frame of its volume.
struct Surface {
  struct Vertex {
    Eigen::Vector3f p = Eigen::Vector3f::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit length, towards free space
    uint8_t grey = 0;
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
};

/// Returns the zero crossings of the distances as a mesh: naive surface nets (Gibson 1998), with one vertex in each cube
/// of eight known voxels of both signs. Unlike marching cubes it has no table, and no slivers. A cube with an unknown
/// voxel has none, so a surface ends where measurements end.
Surface ExtractSurface(const Volume& volume);

/// Moves a surface rigidly.
void Move(const SE3& T_a_surface, Surface& surface);

}  // namespace plslam::dense
