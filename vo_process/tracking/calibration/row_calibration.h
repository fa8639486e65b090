// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"
#include "vo_process/stereo/row_field.h"
#include "vo_process/tracking/calibration/self_calibration.h"

namespace plslam::vo {

// A grid over the image, to measure how widely features are spread and which are close together.

inline constexpr int kCellColumns = 8;
inline constexpr int kCellRows = 6;

/// Row by row; positions outside count to the nearest cell.
inline int CellOf(const Eigen::Vector2d& px, const StereoCamera& camera) {
  const int column = std::clamp(static_cast<int>(kCellColumns * px.x() / camera.width_px), 0, kCellColumns - 1);
  const int row = std::clamp(static_cast<int>(kCellRows * px.y() / camera.height_px), 0, kCellRows - 1);
  return row * kCellColumns + column;
}

/// A match whose patches measure its row independently (corners, not edges): an observation of the vertical disparity.
struct RowObservation {
  /// Index of the point.
  size_t point = 0;
  /// Position as in `RowField`.
  Eigen::Vector2d place_px = Eigen::Vector2d::Zero();
  double offset_px = 0.0;
  double variance_px2 = 1.0;
  /// Number of observations in its cell of the image, which have common errors.
  double sharing = 1.0;
};

/// Returns the observations of the points of a pair.
std::vector<RowObservation> RowObservationsOf(const StereoFeatures& features, const StereoCamera& camera);

/// Largest innovation, in standard deviations, that updates the filter.
inline constexpr double kMaxRowDeviation = 4.0;

/// Returns the factor of the variance of an innovation of so many standard deviations (Huber).
double RowHuberFactor(double deviation);

/// Estimates the vertical disparity between the images while driving (`RowField`).
///
/// Public sequences contain pairs whose rows differ by a pixel towards the corners. Such an offset costs matches, and
/// on a slanted edge it changes the disparity: a segment at 20 degrees to the baseline has an error of 2.7 px per row.
/// Patches with corners measure the row of a match independently, so no motion and no depth is needed. A Kalman filter
/// starts with a prior around the median of the first pair; the field is applied only if it is significant, large
/// enough to matter, and improves most matches: a good calibration is not changed. It follows slow changes, as of
/// temperature, not a shock.
class RowCalibration {
 public:
  RowCalibration(const StereoCamera& camera, const RowCalibrationOptions& options);

  /// Starts from an earlier estimate; before the first frame.
  void Begin(const SelfCalibration::Rows& learned);
  std::optional<SelfCalibration::Rows> learned() const {
    return used_ ? std::optional<SelfCalibration::Rows>({state_, covariance_}) : std::nullopt;
  }

  /// The applied field; zero until it is significant.
  RowField field() const { return used_ ? RowField(camera_, state_, TurnShown()) : RowField(); }

  /// Whether no frame has had enough matches yet to decide. After some frames true only periodically.
  bool needs_look() const {
    const bool now = n_frames_ < kFirstLooks || n_frames_ % kLookEvery == 0;
    return options_.enabled && !has_learned_ && now;
  }

  /// Learns from the matches of a frame, after subtracting the skew of the pair. Returns whether `field` has become
  /// zero or nonzero.
  bool Observe(const StereoFeatures& features, const PairSkew& skew = {});

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.n_frames_, self.has_learned_, self.used_, self.state_, self.covariance_, self.n_compared_,
      self.median_with_px_, self.median_without_px_);
  }

 private:
  static constexpr int64_t kFirstLooks = 10;
  static constexpr int64_t kLookEvery = 30;

  double Innovation_px(const RowObservation& observation) const;
  void Learn(const RowObservation& observation);
  void Compare(const std::vector<RowObservation>& observations);
  bool IsSignificant() const;
  RowField::Turn TurnShown() const;

  StereoCamera camera_;
  RowCalibrationOptions options_;
  int64_t n_frames_ = 0;
  bool has_learned_ = false;
  bool used_ = false;
  RowField::Coefficients state_ = RowField::Coefficients::Zero();
  Eigen::Matrix<double, 6, 6> covariance_;
  /// Median residuals of the last frames, with the field and without it.
  int64_t n_compared_ = 0;
  double median_with_px_ = 0.0;
  double median_without_px_ = 0.0;
};

}  // namespace plslam::vo
