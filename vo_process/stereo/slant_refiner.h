// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "vo_process/stereo/halved_pair.h"

namespace plslam::vo {

/// Alignment of a position in a left patch with the right image, in pixels of the level.
struct SlantedAlignment {
  double shift_u_px = 0.0;
  /// Change of the disparity per pixel to the right and downwards.
  Eigen::Vector2d disparity_slope = Eigen::Vector2d::Zero();
  /// Variance of the shift, from the residuals; too small by the noise in the left patch's own gradients.
  double variance = 0.0;
  double correlation = 0.0;
};

/// Prior of the row offset, in pixels of the level.
struct RowPrior {
  double offset_px = 0.0;
  double information = 0.0;
};

/// Aligns a patch again with a disparity that varies over it, as on surfaces that are not parallel to the images: on a
/// road it changes by baseline over camera height, a third of a pixel per row with a car's rig. A single disparity for
/// the whole patch is that of some position with a strong gradient, an error that grows with the disparity.
///
/// `center` is the central pixel of the patch, at least seven from the left image's border; `off_center` the position
/// in the patch at which the disparity is wanted, `shift` the alignment without slant. Gauss-Newton over shift, row
/// offset (`row` as in `PatchAligner`) and the two slopes, with prior sigma `kSlopeSigma`. Returns nullopt if this does
/// not converge or the slope is implausible.
std::optional<SlantedAlignment> RefineSlanted(const HalvedPair::Level& level, const Eigen::Vector2i& center,
                                              const Eigen::Vector2d& off_center, const Eigen::Vector2d& shift,
                                              const RowPrior& row);

}  // namespace plslam::vo
