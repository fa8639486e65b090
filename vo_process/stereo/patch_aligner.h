// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "vo_process/stereo/halved_pair.h"
#include "vo_process/stereo/row_field.h"

namespace plslam {

/// Where the patch around a left pixel lies in the right image.
struct PatchAlignment {
  double disparity_px = 0.0;
  double sigma_disparity_px = 0.0;
  /// Row in the right image minus row in the left, as the patches alone tell (0 for perfect rectification), and its
  /// standard deviation.
  double row_offset_px = 0.0;
  double sigma_row_px = 0.0;
  /// Normalised correlation of the patches, and contrast of the right relative to the left.
  double correlation = 0.0;
  double gain = 0.0;
};

/// Sub-pixel disparity by aligning 11x11 patches of a rectified pair, for any gain and offset of brightness between
/// the images (their exposures may differ).
///
/// Gauss-Newton on the shift of a fixed left patch (inverse compositional: the normal equations are built once). The
/// shift has a row component, which `rows` predicts to `sigma_row_px`, since no rectification is perfect and a
/// slanted edge would turn its error into disparity. Its marginal standard deviation, from the residuals and the
/// inverse Hessian, is the sigma. Patches of coarse features are taken from halved images.
class PatchAligner {
 public:
  /// `pair` must outlive the aligner.
  PatchAligner(const HalvedPair& pair, double sigma_row_px, const RowField& rows = {})
      : pair_(&pair), sigma_row_px_(sigma_row_px), rows_(rows) {}

  /// Aligns the patch at `left_px`, found at a pixel size of `scale`, starting from `disparity_px`. nullopt where the
  /// patch leaves an image, has no gradient along the row, does not converge, or ends more than 2.5 pixels of its
  /// size from where it started.
  std::optional<PatchAlignment> Align(const Eigen::Vector2d& left_px, double scale, double disparity_px) const;

 private:
  const HalvedPair* pair_;
  double sigma_row_px_;
  RowField rows_;
};

}  // namespace plslam
