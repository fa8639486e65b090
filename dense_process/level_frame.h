// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include "core/map/vertical.h"
#include "dense_process/surface.h"

namespace plslam::dense {

/// Returns the level frame of a map: z up, its origin that of w, x the horizontal direction in which the first keyframe
/// looks.
SE3 LevelFrame(const Vertical& vertical);

/// The floor in the level frame: the lowest large horizontal surface, followed over ramps and hills in square tiles.
///
/// The tile with most horizontal surface begins, at the lowest height that has at least a third of its largest layer.
/// Neighbours follow with their own layer near that height. Tiles without one have the height of their nearest
/// neighbour.
class Floor {
 public:
  /// `surface` in the level frame.
  Floor(const Surface& surface, double voxel_m);

  /// Whether there is any horizontal surface; otherwise `HeightAt` is 0.
  bool found() const { return !height_of_.empty(); }
  double HeightAt(double x_m, double y_m) const;

 private:
  using Tile = std::pair<int, int>;
  Tile TileAt(double x_m, double y_m) const;

  double tile_m_;
  std::map<Tile, double> height_of_;
};

}  // namespace plslam::dense
