// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/io/images/image_file.h"

namespace plslam::calibration {

/// The cell of a pixel, row by row, where the image is divided into `columns` by `rows`.
size_t CellOf(const Eigen::Vector2d& pixel, const ImageSize& size, int columns, int rows);

/// Pixels in each cell, in the same order.
std::vector<int> CountsOfCells(const std::vector<Eigen::Vector2d>& pixels, const ImageSize& size, int columns,
                               int rows);

/// How corners are spread over the images of one camera: a picture of `kCoverageRows` lines, '.' for a cell with a
/// few corners, 'o' for more, '#' for many.
inline constexpr int kCoverageColumns = 32;
inline constexpr int kCoverageRows = 12;
std::vector<std::string> CoveragePicture(const std::vector<Eigen::Vector2d>& pixels, const ImageSize& size);

/// Returns the ninths of the image that have hardly any corners: "upper left corner", "left edge", "centre". Not the
/// number of corners decides, but their spread: corners lie in less than a fifth of the area.
std::vector<std::string> EmptyRegions(const std::vector<Eigen::Vector2d>& pixels, const ImageSize& size);

}  // namespace plslam::calibration
