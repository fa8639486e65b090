// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/camera_view.h"

namespace plslam {

/// Shorter segments are not adjusted.
inline constexpr double kMinAdjusted_m = 1e-6;

/// An image's view of a segment: the infinite line through it, with pixels relative to the principal point.
struct ObservedImage {
  ObservedImage() = default;
  ObservedImage(const Eigen::Vector2d& p_px, const Eigen::Vector2d& q_px, double f_px_in, double baseline_m_in);

  /// Distance of a projected point to the line, and its derivative by the point (in the left camera).
  double Distance(const Eigen::Vector3d& p_c, Eigen::Vector3d& by_p_c) const {
    const double k = f_px / p_c.z();
    const double across_px = k * (normal.x() * (p_c.x() - baseline_m) + normal.y() * p_c.y());
    by_p_c = {k * normal.x(), k * normal.y(), -across_px / p_c.z()};
    return across_px - offset_px;
  }

  Eigen::Vector2d normal = Eigen::Vector2d::UnitY();
  double offset_px = 0.0;
  double f_px = 0.0;
  /// Where the camera is along x of the left one.
  double baseline_m = 0.0;
};

/// Both images of an observation; `has_right` is false where a disparity is missing or the right segment has no
/// length.
struct ObservedImages {
  ObservedImages(const LineObservation& observation, const StereoCamera& camera);

  ObservedImage left;
  ObservedImage right;
  bool has_right = false;
};

/// Two directions across the line through a segment, and so orthonormal and a basis of what a line can do there.
using Across = Eigen::Matrix<double, 3, 2>;
Across DirectionsAcross(const Segment3& segment);

/// A line by four numbers: its endpoints move only across the direction that it had at the start.
struct AdjustedLine {
  static constexpr int kSize = 4;
  static constexpr bool kAlwaysPrior = false;
  using Parameters = Eigen::Vector4d;

  explicit AdjustedLine(const BundleLine& line);

  bool IsUsable() const;
  Segment3 At(const double* parameters) const;
  Segment3 Segment() const { return At(x.data()); }
  /// Covariances of the endpoints, from that of the parameters.
  std::array<Eigen::Matrix3d, 2> EndCovariances(const Eigen::Matrix4d& covariance) const;
  Eigen::Vector3d Middle() const { return 0.5 * (Segment().p + Segment().q); }
  /// Root of the information of a weak prior.
  Eigen::Matrix4d PriorWeight(double distance_m) const { return Eigen::Matrix4d::Identity() / distance_m; }

  Segment3 start_segment;
  Across across;
  Parameters x = Parameters::Zero();
  Parameters start = Parameters::Zero();
  bool free;
};

/// One view of a line: for each end of the observed segment, the place of the landmark that was seen there (found
/// between passes, and carried along by the endpoints) is compared with the infinite observed lines in the left and
/// the right image. Whitened distances; rows: left p, right p, left q, right q; without disparities left p, left q.
///
/// So the noise is stated where it arises, at the two ends, and the distances stay nearly linear in the parameters.
/// The right end has the error of the left one across the line minus that of its disparity; the right rows hold what
/// is not explained by the left ones. A line parallel to the baseline has almost nothing in them, and gets no weight.
class LineCost {
 public:
  using Landmark = AdjustedLine;
  static constexpr int kMaxRows = 4;
  static constexpr bool kShiftsAgainstCamera = false;

  LineCost() = default;
  LineCost(const LineObservation& observation, const AdjustedLine& line, const CameraView& view,
           const StereoCamera& camera);

  /// False for what cannot be measured: not finite, sigmas that are not positive, segments without length.
  static bool IsUsable(const LineObservation& observation);

  /// Finds what was seen.
  void Anchor(const CameraView& view, const AdjustedLine& line);

  int rows() const { return has_right_ ? 4 : 2; }

  /// As `PointCost::Evaluate`, with `rows()` x 4 for the landmark. False where what was seen is behind the camera; an
  /// endpoint that was not seen may be there.
  bool Evaluate(const CameraView& view, const double* x, double* residuals, double* by_pose,
                double* by_landmark) const;

  /// Mean squared distance of the two ends in the left image, from whitened residuals.
  double SquaredPixels(const double* residuals) const {
    const double q = residuals[has_right_ ? 2 : 1];
    return (residuals[0] * residuals[0] + q * q) / (2.0 * weight_ * weight_);
  }

 private:
  struct End {
    /// Share of q in the place of the landmark that was seen: 0 at p, 1 at q.
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
  /// Share of a left end's error that the right end has, too.
  double shared_;
  bool has_right_;
};

}  // namespace plslam
