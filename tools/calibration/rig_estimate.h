// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/io/images/image_file.h"
#include "tools/calibration/board.h"
#include "tools/calibration/markers.h"

namespace plslam {

/// One picture pair: what was seen of the board in each (nothing: empty), and how the pair is called.
struct BoardPair {
  std::string name;
  BoardView left;
  BoardView right;
};

/// A stereo rig, estimated from pictures of a board.
struct RigEstimate {
  RigCalibration rig;
  /// Standard deviations of fx fy cx cy and the coefficients, in their units.
  std::vector<double> left_sigma;
  std::vector<double> right_sigma;
  /// Of `T_left_right`: translation [m] and rotation [rad], perturbed on the right; and of its length.
  Eigen::Matrix<double, 6, 1> T_left_right_sigma = Eigen::Matrix<double, 6, 1>::Zero();
  double baseline_sigma_m = 0.0;
  /// Of one coordinate of a corner that was used, root mean square over degrees of freedom.
  double noise_px = 0.0;
  int used_corners = 0;
  int left_out_corners = 0;
  /// Pictures that took part, and those whose left and right views do not belong together.
  std::vector<int> used_pairs;
  std::vector<std::string> left_out_pairs;
  /// Largest angles between the board and the image plane.
  double max_tilt_deg = 0.0;
};

/// `n` pairs of all, chosen so that corners lie everywhere in both images (indices, ascending).
std::vector<int> ChoosePairs(const std::vector<BoardPair>& pairs, const ImageSize& size, int n);

/// Estimates both cameras and the rig together: maximum likelihood of the corners' pixels with a robust loss, after
/// Zhang, "A flexible new technique for camera calibration" (TPAMI 2000); corners and pairs far outside are left out,
/// and standard deviations are those of the remaining noise. `model` is "radtan" or "equidistant".
/// Throws std::runtime_error with one sentence where there are too few views, left and right are
/// exchanged, pairs were not taken at the same moment, or the pictures do not determine the lens.
RigEstimate EstimateRig(const Board& board, const std::vector<BoardPair>& pairs, const ImageSize& size,
                        const std::string& model);

}  // namespace plslam
