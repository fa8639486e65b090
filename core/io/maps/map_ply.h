// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "core/map/map.h"

namespace plslam {

/// Red, green, blue.
using Colour = std::array<uint8_t, 3>;

/// Colours points by their height over the others of the map: low blue, over green and yellow, to high red. Up is
/// that of the map (VerticalOf). The highest and the lowest fiftieth take the colours of the ends, so that outliers
/// do not take all the colours.
class HeightColours {
 public:
  explicit HeightColours(const Map& map);

  Colour operator()(const Eigen::Vector3d& p_w) const;

 private:
  double HeightOf(const Eigen::Vector3d& p_w) const { return up_w_.dot(p_w); }

  Eigen::Vector3d up_w_;
  double low_ = 0.0;
  double high_ = 0.0;
};

/// Colour of a line by its number of observing keyframes: violet for few, green for 20 and more.
Colour ObservationsColour(size_t observations);

/// Writes the landmarks as a PLY file (binary, little endian) for CloudCompare and MeshLab, in metres in w. Vertices
/// are the points, then both ends of each line, with x, y, z, red, green, blue, and the number of keyframes that see
/// the landmark (`observations`); edges join the ends of the lines. Points are coloured by height, low blue to high red
/// (up is that of VerticalOf); lines by observations, violet for few to green for 20 and more. The order is that of the
/// ids.
std::string MapPly(const Map& map);

}  // namespace plslam
