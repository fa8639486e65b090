// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

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

/// Of a line by the keyframes that see it: violet for few, green for 20 and more.
Colour ObservationsColour(size_t observations);

}  // namespace plslam
