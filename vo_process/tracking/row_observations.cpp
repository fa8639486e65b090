// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/row_observations.h"

#include <algorithm>
#include <array>

#include "vo_process/tracking/image_cells.h"

namespace plslam {
namespace {

// Patches that tell the row less well have little to say, and their errors are not of the normal kind.
constexpr double kMaxSigmaRow_px = 0.4;
// What the residuals of a patch do not show: slant, interpolation, the place of the corner in an image that is not
// sharp.
constexpr double kRowModelError_px = 0.2;
// Corners that lie together, or are the same one in several octaves, err together: a cell of the image has one voice.
constexpr double kRowHuber = 1.5;

bool TellsItsRow(const StereoPoint& p) {
  return p.HasDepth() && p.sigma_row_px >= 0.0 && p.sigma_row_px < kMaxSigmaRow_px;
}

}  // namespace

double RowHuberFactor(double deviation) { return std::max(1.0, deviation / kRowHuber); }

std::vector<RowObservation> RowObservationsOf(const StereoFeatures& features, const StereoCamera& camera) {
  std::vector<RowObservation> observations;
  std::array<int, kCellColumns * kCellRows> n_in_cell{};
  std::vector<size_t> cells;
  for (size_t i = 0; i < features.points.size(); ++i) {
    const StereoPoint& point = features.points[i];
    if (!TellsItsRow(point)) continue;
    const Eigen::Vector2d place_px = point.left.px - Eigen::Vector2d(point.disparity_px, 0.0);
    cells.push_back(static_cast<size_t>(CellOf(place_px, camera)));
    ++n_in_cell[cells.back()];
    observations.push_back({i, place_px, point.row_offset_px,
                            point.sigma_row_px * point.sigma_row_px + kRowModelError_px * kRowModelError_px});
  }
  for (size_t i = 0; i < observations.size(); ++i) observations[i].sharing = n_in_cell[cells[i]];
  return observations;
}

}  // namespace plslam
