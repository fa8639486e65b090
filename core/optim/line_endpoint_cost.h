#pragma once

#include <array>

#include "core/optim/bundle.h"
#include "core/optim/camera_view.h"

namespace plslam {

/// A line by its two endpoints, as in the paper. What they do along the line is not measured.
struct AdjustedEndpoints {
  static constexpr int kSize = 6;
  using Parameters = Vector6d;

  explicit AdjustedEndpoints(const BundleLine& line);

  bool IsUsable() const;
  Segment3 Segment() const { return {x.head<3>(), x.tail<3>()}; }
  /// Covariances of the endpoints across the line, from that of the parameters.
  std::array<Eigen::Matrix3d, 2> EndCovariances(const Matrix6d& covariance) const;
  Eigen::Vector3d Middle() const { return 0.5 * (x.head<3>() + x.tail<3>()); }

  Parameters x;
  Parameters start;
  bool free;
};

/// One view of a line as in the paper (PL-SLAM §V.B): whitened distances of the projected endpoints to the infinite lines
/// through the observed segment, in the left and the right image. Rows: left p, left q, right p, right q; without
/// disparities the left ones.
///
/// The observed line is known at its ends, so the distances are correlated and less certain beyond them (see
/// core/motion/line_residual.h). Where the endpoints are along it is taken from the start.
class LineEndpointCost {
 public:
  using Landmark = AdjustedEndpoints;
  static constexpr int kMaxRows = 4;

  LineEndpointCost() = default;
  LineEndpointCost(const LineSight& sight, const AdjustedEndpoints& line, const CameraView& view,
                   const StereoCamera& camera);

  /// As `LineCost::IsUsable`.
  static bool IsUsable(const LineSight& sight);

  int rows() const { return rows_; }

  /// As `PointCost::Evaluate`, with `rows()` x 6 for the landmark. False where an endpoint is behind the camera.
  bool Evaluate(const CameraView& view, const double* x, double* residuals, double* by_pose,
                double* by_landmark) const;

  bool Plausible(const CameraView&, const double*) const { return true; }

  /// As `LineCost::SquaredPixels`, of the projected endpoints.
  double SquaredPixels(const double* residuals) const {
    const double p = residuals[0] / whitening_(0, 0);
    const double q = (residuals[1] - whitening_(1, 0) * p) / whitening_(1, 1);
    return 0.5 * (p * p + q * q);
  }

 private:
  /// An image's view of the segment, relative to the principal point.
  struct Image {
    Image() = default;
    Image(const Eigen::Vector2d& p_px, const Eigen::Vector2d& q_px, double baseline_m_in);

    Eigen::Vector2d start_px = Eigen::Vector2d::Zero();
    Eigen::Vector2d normal = Eigen::Vector2d::UnitY();
    double baseline_m = 0.0;
  };

  /// Distance of a projected point to the line of the image, and its derivative by the point.
  double Distance(const Image& image, const Eigen::Vector3d& p_c, Eigen::Vector3d& by_p_c) const;
  void Weigh(const LineSight& sight, const AdjustedEndpoints& line, const CameraView& view);

  Image left_;
  Image right_;
  Eigen::Matrix4d whitening_ = Eigen::Matrix4d::Identity();
  double f_px_;
  double min_depth_m_;
  int rows_;
};

}  // namespace plslam
