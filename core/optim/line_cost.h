#pragma once

#include <array>

#include "core/optim/bundle.h"
#include "core/optim/camera_view.h"

namespace plslam {

/// Two directions across the line through a segment, and so orthonormal and a basis of what a line can do there.
using Across = Eigen::Matrix<double, 3, 2>;
Across DirectionsAcross(const Segment3& segment);

/// A line by four numbers: its endpoints move only across the direction that it had at the start.
struct AdjustedLine {
  static constexpr int kSize = 4;
  using Parameters = Eigen::Vector4d;

  explicit AdjustedLine(const BundleLine& line);

  bool IsUsable() const;
  Segment3 At(const double* parameters) const;
  Segment3 Segment() const { return At(x.data()); }
  /// Covariances of the endpoints, from that of the parameters.
  std::array<Eigen::Matrix3d, 2> EndCovariances(const Eigen::Matrix4d& covariance) const;
  Eigen::Vector3d Middle() const { return 0.5 * (Segment().p + Segment().q); }

  Segment3 start_segment;
  Across across;
  Parameters x = Parameters::Zero();
  Parameters start = Parameters::Zero();
  bool free;
};

/// One view of a line: whitened distances of the ends of the observed segment, in the left and the right image, to the
/// infinite line that the landmark projects to. Rows: left p, right p, left q, right q; without disparities left p, left q.
///
/// The noise is stated where it arises: each observed end errs across the line, and the right end by the same amount
/// minus the error of its disparity. So the right rows hold what is not explained by the left ones. A line parallel
/// to the baseline has almost nothing in its right rows, and gets no weight from them.
class LineCost {
 public:
  using Landmark = AdjustedLine;
  static constexpr int kMaxRows = 4;

  LineCost() = default;
  LineCost(const LineSight& sight, const AdjustedLine& line, const CameraView& view, const StereoCamera& camera);

  /// False for what cannot be measured: not finite, sigmas that are not positive, segments without length.
  static bool IsUsable(const LineSight& sight);

  int rows() const { return has_right_ ? 4 : 2; }

  /// As `PointCost::Evaluate`, with `rows()` x 4 for the landmark. False where both endpoints are behind the camera, or
  /// the line passes through its centre. One endpoint may be behind: the line is what is seen.
  bool Evaluate(const CameraView& view, const double* x, double* residuals, double* by_pose,
                double* by_landmark) const;

  /// Whether the part of the line that was seen is in front of the camera.
  bool Plausible(const CameraView& view, const double* x) const;

  /// Mean squared distance of the two ends in the left image, from whitened residuals.
  double SquaredPixels(const double* residuals) const {
    const double q = residuals[has_right_ ? 2 : 1];
    return (residuals[0] * residuals[0] + q * q) / (2.0 * weight_ * weight_);
  }

 private:
  /// Viewing rays of one end, z = 1.
  struct End {
    Eigen::Vector3d left;
    Eigen::Vector3d right;
    double weight_right;
  };

  const AdjustedLine* line_;
  std::array<End, 2> ends_;
  double weight_;
  double f_px_;
  double baseline_m_;
  double min_depth_m_;
  /// Share of a left end's error that the right end has, too.
  double shared_;
  bool has_right_;
};

}  // namespace plslam
