// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/config/fields.h"

namespace plslam::dense {

/// Section `dense` of the configuration.
struct DenseOptions {
  std::string out = "out";
  std::string map_file;
  std::string state_file;
  double voxel_m = 0.0;
  double range_m = 0.0;
  double robot_height_m = 1.0;
  std::vector<double> up;
};

template <class Visitor>
void VisitFields(Visitor& visit, DenseOptions& o) {
  visit("out", o.out, "folder for the surfaces and the grid");
  visit("map_file", o.map_file, "surfaces of a saved map (FILE.surfaces) to continue; empty: none");
  visit("state_file", o.state_file,
        "file with the surfaces so far, for a restart: continued if it exists; empty: none");
  visit("voxel_m", o.voxel_m, Bounds{0.0, 1.0}, "edge of a voxel and of a cell, in m; 0: 0.05 indoors, 0.2 on roads");
  visit("range_m", o.range_m, Bounds{0.0, 100.0}, "largest depth in use, in m; 0: where it is known to 2.5 voxels");
  visit("robot_height_m", o.robot_height_m, Bounds{0.2, 10.0},
        "obstacles of the grid are between 0.1 m and this height above the floor, in m");
  visit(
      "up", o.up,
      "up of the mounted camera: three numbers in its own frame (x right, y down, z forward), [0, -1, 0] if it looks "
      "ahead; empty: the map has the vertical by an inertial sensor or by lines");
}

}  // namespace plslam::dense
