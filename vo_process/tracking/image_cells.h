// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include <Eigen/Core>

#include "core/geometry/stereo_camera.h"

namespace plslam {

// An image in cells, for counting how widely something is spread, and what lies together.

inline constexpr int kCellColumns = 8;
inline constexpr int kCellRows = 6;

/// Row by row; places outside count to the nearest.
inline int CellOf(const Eigen::Vector2d& px, const StereoCamera& camera) {
  const int column = std::clamp(static_cast<int>(kCellColumns * px.x() / camera.width_px), 0, kCellColumns - 1);
  const int row = std::clamp(static_cast<int>(kCellRows * px.y() / camera.height_px), 0, kCellRows - 1);
  return row * kCellColumns + column;
}

}  // namespace plslam
