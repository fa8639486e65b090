// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/camera_view.h"
#include "core/optim/bundle/line_cost.h"

namespace plslam {

/// A line with its two endpoints as parameters, as in the paper. Positions along the line are not measured.
struct AdjustedEndpoints {
  static constexpr int kSize = 6;
  /// The apparent information along the line is noise.
  static constexpr bool kAlwaysPrior = true;
  using Parameters = Vector6d;

  explicit AdjustedEndpoints(const BundleLine& line);

  bool IsUsable() const;
  Segment3 Segment() const { return {x.head<3>(), x.tail<3>()}; }
  /// Covariances of the endpoints across the line, from that of the parameters.
  std::array<Eigen::Matrix3d, 2> EndCovariances(const Matrix6d& covariance) const;
  Eigen::Vector3d Middle() const { return 0.5 * (x.head<3>() + x.tail<3>()); }
  /// Square root of the information of a weak prior, which is strong along the line: residuals contain only noise about
  /// that direction, and endpoints would drift with it.
  Matrix6d PriorWeight(double distance_m) const;

  Parameters x;
  Parameters start;
  bool free;
};

/// One observation of a line as in the paper (PL-SLAM §V.B): whitened distances of the projected endpoints from the
/// infinite lines through the observed segment, in the left and the right image. Rows: left p, left q, right p, right
/// q; without disparities the left ones.
///
/// The observed line is determined by its ends, so the distances are correlated, and less certain beyond them (see
/// core/motion/line_residual.h). The positions of the endpoints along it are updated between passes.
class LineEndpointCost {
 public:
  using Landmark = AdjustedEndpoints;
  static constexpr int kMaxRows = 4;
  static constexpr bool kShiftsAgainstCamera = false;

  LineEndpointCost() = default;
  LineEndpointCost(const LineObservation& observation, const AdjustedEndpoints& line, const CameraView& view,
                   const StereoCamera& camera);

  /// As `LineCost::IsUsable`.
  static bool IsUsable(const LineObservation& observation);

  /// Recomputes the weights from the positions of the endpoints.
  void Anchor(const CameraView& view, const AdjustedEndpoints& line);

  int rows() const { return rows_; }

  /// As `PointCost::Evaluate`, with `rows()` x 6 for the landmark. Returns false if an endpoint is behind the camera.
  bool Evaluate(const CameraView& view, const double* x, double* residuals, double* by_pose,
                double* by_landmark) const;

  /// As `LineCost::SquaredPixels`, for the projected endpoints.
  double SquaredPixels(const double* residuals) const {
    const double p = residuals[0] / whitening_(0, 0);
    const double q = (residuals[1] - whitening_(1, 0) * p) / whitening_(1, 1);
    return 0.5 * (p * p + q * q);
  }

 private:
  ObservedImage left_;
  ObservedImage right_;
  Eigen::Matrix4d whitening_ = Eigen::Matrix4d::Identity();
  /// Relative to the principal point.
  Eigen::Vector2d start_px_;
  double length_px_;
  double sigma_px_;
  double sigma_disparity_p_px_;
  double sigma_disparity_q_px_;
  double min_depth_m_;
  int rows_;
};

}  // namespace plslam
