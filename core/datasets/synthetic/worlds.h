// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/datasets/synthetic/motion.h"
#include "core/datasets/synthetic/world.h"
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

/// Requirements of a world.
struct WorldRequest {
  uint64_t seed = 1;
  /// Positions of the camera, z upwards, metres; nothing solid is placed near them.
  std::vector<Eigen::Vector3d> path;
  /// The path is from a file and determines the size of the world. Otherwise it is the world's own path.
  bool from_file = false;
  /// A room after some of its posters, books and boxes were replaced or moved.
  bool is_changed = false;
};

/// One row for each built-in world. All are built with z upwards.
struct WorldKind {
  const char* name;
  double baseline_m;
  double fov_deg;
  Walk (*walk)();
  World (*build)(const WorldRequest&);
};

/// Precondition: `name` is in the table.
const WorldKind& FindWorldKind(const std::string& name);
const std::vector<WorldKind>& WorldKinds();

/// A furnished room of 8 x 6 x 3 m: posters, shelves, a door, windows, boxes.
Walk RoomWalk();
World BuildRoom(const WorldRequest& request);

/// A rectangle of corridors, 2.4 m wide, with identical doors and hardly any texture.
Walk CorridorWalk();
World BuildCorridor(const WorldRequest& request);

/// Houses, kerbs, lamp posts and parked cars on both sides of the path.
Walk StreetWalk();
World BuildStreet(const WorldRequest& request);

/// A white room of long soft edges and almost no corners.
Walk WhitewallWalk();
World BuildWhitewall(const WorldRequest& request);

}  // namespace plslam::synthetic
