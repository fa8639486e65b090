// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "core/datasets/synthetic/world_builder.h"

namespace plslam::synthetic {

/// An axis-parallel hall, z upwards.
struct Hall {
  Eigen::Vector3d low;
  Eigen::Vector3d high;

  Eigen::Vector3d size() const { return high - low; }
  Face Floor() const;
  Face Ceiling() const;
  /// The four walls as seen from inside, anticlockwise from the one at low y.
  std::array<Face, 4> Walls() const;
};

/// The hall of a given size about the origin with its floor at z = 0; or, for a path from a file, the one that leaves
/// `margin_m` on all sides of the path and has at least that size.
Hall HallFor(const std::vector<Eigen::Vector3d>& path, bool from_file, const Eigen::Vector3d& size,
             const Eigen::Vector3d& margin_m);

}  // namespace plslam::synthetic
