// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/calibration.h"
#include "core/io/images/image_file.h"
#include "tools/calibration/board.h"
#include "tools/calibration/markers.h"

namespace plslam::calibration {

/// Pixel of a point (camera frame, z > 0) with the parameters fx fy cx cy and then the lens model's coefficients. The
/// same lenses as core/geometry/distortion.h, which has derivatives by the point only: this is a template, so that
/// Ceres differentiates by the parameters too. "radtan" has its k3. Returns whether the model holds there.
template <typename T>
bool ProjectLens(std::string_view model, const T* parameters, const T* p, T* pixel) {
  using std::atan2;
  using std::sqrt;
  if (!(p[2] > T(1e-6))) return false;
  const T* k = parameters + 4;
  T x = p[0] / p[2], y = p[1] / p[2];
  const T r2 = x * x + y * y;
  if (model == lens_model::kRadtan || model == lens_model::kRational) {
    T radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    if (model == lens_model::kRational) {
      const T divisor = 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
      if (!(divisor > T(1e-3))) return false;
      radial /= divisor;
    }
    const T xd = x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x);
    y = y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y;
    x = xd;
  } else if (model == lens_model::kDoubleSphere) {
    const T depth = 1.0 + k[0] * sqrt(r2 + 1.0);
    const T divisor = k[1] * sqrt(r2 + depth * depth) + (1.0 - k[1]) * depth;
    if (!(divisor > T(1e-3))) return false;
    x /= divisor;
    y /= divisor;
  } else if (r2 > T(1e-16)) {
    // Equidistant. The square root has no derivative at 0.
    const T r = sqrt(r2), angle = atan2(r, T(1.0)), a2 = angle * angle;
    const T scale = angle * (1.0 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3])))) / r;
    x = scale * x;
    y = scale * y;
  }
  pixel[0] = parameters[0] * x + parameters[2];
  pixel[1] = parameters[1] * y + parameters[3];
  return true;
}

/// One picture pair: the view of the board in each (not seen: empty), and the pair's name.
struct BoardPair {
  std::string name;
  BoardView left;
  BoardView right;
};

/// If a chess board looks the same from both of its ends, the left and the right picture may number its corners from
/// different ends, although the cameras of a rig see it nearly alike: returns `right` numbered as `left`.
BoardView NumberedLike(const Board& board, const BoardView& left, BoardView right);

/// A stereo rig, estimated from pictures of a board.
struct RigEstimate {
  RigCalibration rig;
  /// Covariances of fx fy cx cy and the coefficients, in their units.
  Eigen::MatrixXd left_covariance;
  Eigen::MatrixXd right_covariance;
  /// Standard deviations of `T_left_right`: translation [m] and rotation [rad], perturbed on the right; and of the
  /// baseline.
  Eigen::Matrix<double, 6, 1> T_left_right_sigma = Eigen::Matrix<double, 6, 1>::Zero();
  double baseline_sigma_m = 0.0;
  /// Standard deviations of the translation of `T_left_right` alone, along the axes of the left camera.
  Eigen::Vector3d right_in_left_sigma_m = Eigen::Vector3d::Zero();
  /// Noise of one coordinate of a used corner, root mean square over degrees of freedom.
  double noise_px = 0.0;
  int used_corners = 0;
  int left_out_corners = 0;
  /// Used pictures, and pairs that were rejected because their left and right views do not belong together.
  std::vector<int> used_pairs;
  std::vector<std::string> left_out_pairs;
  /// Largest angles between the board and the image plane.
  double max_tilt_deg = 0.0;
};

/// `n` pairs of all, chosen so that corners lie everywhere in both images (indices, ascending).
std::vector<int> ChoosePairs(const std::vector<BoardPair>& pairs, const ImageSize& size, int n);

/// Estimates both cameras and the rig together: maximum likelihood of the corners' pixels with a robust loss, after
/// Zhang, "A flexible new technique for camera calibration" (TPAMI 2000); corners and pairs far outside are left out,
/// and standard deviations are those of the remaining noise. `model` is a lens model with coefficients.
///
/// The denominator of "rational" and the two spheres of "double_sphere" can compensate each other over the field of
/// view of a usual lens: without a prior the pictures do not determine them, along a curved valley in which standard
/// deviations are meaningless. These coefficients have a wide normal prior, that of lenses as published, which moves
/// pixels by far less than the noise does. Their standard deviations are then mostly those of the prior; well
/// determined are `FocalInCentre` and `PixelSigma_px`. Throws std::runtime_error with one sentence if there are too few
/// views, left and right are exchanged, pairs were not taken at the same moment, or the pictures do not determine the
/// lens.
RigEstimate EstimateRig(const Board& board, const std::vector<BoardPair>& pairs, const ImageSize& size,
                        const std::string& model);

/// Parameters in the order of the covariances.
std::vector<double> LensParameters(const CameraCalibration& camera);

/// Focal length along x that the centre of the image has, in pixels: fx but for "double_sphere".
double FocalInCentre_px(const CameraCalibration& camera);
/// Its standard deviation.
double FocalInCentreSigma_px(const CameraCalibration& camera, const Eigen::MatrixXd& covariance);

/// Derivative of the pixel of the ray (x, y) at z = 1 by the parameters of the lens, 2 x n; none where the
/// lens model does not hold there.
std::optional<Eigen::MatrixXd> PixelJacobian(const CameraCalibration& camera, const Eigen::Vector2d& xy);

/// Returns the largest standard deviation of the pixel at which a ray meets the image: the uncertainty of the lens as a
/// whole.
double PixelSigma_px(const CameraCalibration& camera, const Eigen::MatrixXd& covariance);

}  // namespace plslam::calibration
