// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/camera_view.h"

namespace plslam {

/// Shorter segments are not adjusted.
inline constexpr double kMinAdjusted_m = 1e-6;

/// The infinite line through an observed segment in one image, in pixels relative to the principal point.
struct ObservedImage {
  ObservedImage() = default;
  ObservedImage(const Eigen::Vector2d& p_px, const Eigen::Vector2d& q_px, double f_px_in, double baseline_m_in);

  /// Distance in pixels of a projected point from the line, and its derivative by the point (in the left camera).
  double Distance(const Eigen::Vector3d& p_c, Eigen::Vector3d& by_p_c) const {
    const double k = f_px / p_c.z();
    const double across_px = k * (normal.x() * (p_c.x() - baseline_m) + normal.y() * p_c.y());
    by_p_c = {k * normal.x(), k * normal.y(), -across_px / p_c.z()};
    return across_px - offset_px;
  }

  Eigen::Vector2d normal = Eigen::Vector2d::UnitY();
  double offset_px = 0.0;
  double f_px = 0.0;
  /// Position of the camera along x of the left one.
  double baseline_m = 0.0;
};

/// Both images of an observation; `has_right` is false if a disparity is missing or the right segment has no length.
struct ObservedImages {
  ObservedImages(const LineObservation& observation, const StereoCamera& camera);

  ObservedImage left;
  ObservedImage right;
  bool has_right = false;
};

/// Two orthonormal directions across the line through a segment: a basis of its possible displacements.
using Across = Eigen::Matrix<double, 3, 2>;
Across DirectionsAcross(const Segment3& segment);

/// A line with four parameters: its endpoints move only across the start direction.
struct AdjustedLine {
  static constexpr int kSize = 4;
  static constexpr bool kAlwaysPrior = false;
  using Parameters = Eigen::Vector4d;

  explicit AdjustedLine(const BundleLine& line);

  bool IsUsable() const;
  Segment3 At(const double* parameters) const;
  Segment3 Segment() const { return At(x.data()); }
  /// Returns the covariances of the endpoints, given that of the parameters.
  std::array<Eigen::Matrix3d, 2> EndCovariances(const Eigen::Matrix4d& covariance) const;
  Eigen::Vector3d Middle() const { return 0.5 * (Segment().p + Segment().q); }
  /// Square root of the information of a weak prior.
  Eigen::Matrix4d PriorWeight(double distance_m) const { return Eigen::Matrix4d::Identity() / distance_m; }

  Segment3 start_segment;
  Across across;
  Parameters x = Parameters::Zero();
  Parameters start = Parameters::Zero();
  bool free;
};

/// One observation of a line: for each end of the observed segment, the point of the landmark observed there (found
/// between passes, and moved with the endpoints) is compared with the infinite observed lines in the left and the
/// right image. Whitened distances; rows: left p, right p, left q, right q; without disparities left p, left q.
///
/// The noise is thus modelled where it arises, at the two ends, and the distances are nearly linear in the parameters.
/// The right end has the left one's error across the line minus that of its disparity; the right rows are the part
/// that the left rows do not explain. For a line parallel to the baseline they contain almost nothing and have no
/// weight.
class LineCost {
 public:
  using Landmark = AdjustedLine;
  static constexpr int kMaxRows = 4;
  static constexpr bool kShiftsAgainstCamera = false;

  LineCost() = default;
  LineCost(const LineObservation& observation, const AdjustedLine& line, const CameraView& view,
           const StereoCamera& camera);

  /// False for invalid observations: not finite, sigmas not positive, segments without length.
  static bool IsUsable(const LineObservation& observation);

  /// Finds the observed points of the landmark.
  void Anchor(const CameraView& view, const AdjustedLine& line);

  int rows() const { return has_right_ ? 4 : 2; }

  /// As `PointCost::Evaluate`, with `rows()` x 4 for the landmark. Returns false if an observed point is behind the
  /// camera; endpoints that were not observed may be.
  bool Evaluate(const CameraView& view, const double* x, double* residuals, double* by_pose,
                double* by_landmark) const;

  /// Mean squared distance of the two ends in the left image, in px^2, from whitened residuals.
  double SquaredPixels(const double* residuals) const {
    const double q = residuals[has_right_ ? 2 : 1];
    return (residuals[0] * residuals[0] + q * q) / (2.0 * weight_ * weight_);
  }

 private:
  struct End {
    /// Position of the observed point along the segment: 0 at p, 1 at q.
    double along;
    Eigen::Vector3d ray;
    double weight_right;
  };

  const AdjustedLine* line_;
  ObservedImage left_;
  ObservedImage right_;
  std::array<End, 2> ends_;
  double weight_;
  double min_depth_m_;
  /// Share of a left end's error in the right end.
  double shared_;
  bool has_right_;
};

}  // namespace plslam
