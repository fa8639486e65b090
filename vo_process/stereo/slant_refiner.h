// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "vo_process/stereo/halved_pair.h"

namespace plslam::vo {

/// Where a place in a left patch lies in the right image, all in pixels of the level.
struct SlantedAlignment {
  double shift_u_px = 0.0;
  /// Of the shift, from the residuals; noise in the left patch's own gradients makes it look smaller than it is.
  double variance = 0.0;
  double correlation = 0.0;
};

/// What is known of the row offset before, in pixels of the level.
struct RowPrior {
  double offset_px = 0.0;
  double information = 0.0;
};

/// Aligns a patch once more with a disparity that changes over it, as on surfaces that are not parallel to the
/// images: on a road it changes by baseline over camera height, a third of a pixel each row with a car's rig. One
/// disparity for the whole patch is then that of some place of strong gradient in it, an error that grows with the
/// disparity.
///
/// `center` is the pixel that the patch is around, at least seven from the left image's border; `off_center` where in
/// it the disparity is wanted, `shift` the alignment without slant. Gauss-Newton over shift, row offset (`row` as in
/// `PatchAligner`) and the two slopes, which are expected to be `kSlopeSigma`. nullopt where this does not converge
/// or the slope is beyond reason.
std::optional<SlantedAlignment> RefineSlanted(const HalvedPair::Level& level, const Eigen::Vector2i& center,
                                              const Eigen::Vector2d& off_center, const Eigen::Vector2d& shift,
                                              const RowPrior& row);

}  // namespace plslam::vo
