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
#include "vo_process/tracking/self_calibration.h"

namespace plslam::vo {

// An image in cells, for counting how widely something is spread, and what lies together.

inline constexpr int kCellColumns = 8;
inline constexpr int kCellRows = 6;

/// Row by row; places outside count to the nearest.
inline int CellOf(const Eigen::Vector2d& px, const StereoCamera& camera) {
  const int column = std::clamp(static_cast<int>(kCellColumns * px.x() / camera.width_px), 0, kCellColumns - 1);
  const int row = std::clamp(static_cast<int>(kCellRows * px.y() / camera.height_px), 0, kCellRows - 1);
  return row * kCellColumns + column;
}

/// A match whose patches tell its row without knowing it (corners, not edges): what is learned from of how rows
/// differ.
struct RowObservation {
  /// Which of the points.
  size_t point = 0;
  /// As `RowField` tells places.
  Eigen::Vector2d place_px = Eigen::Vector2d::Zero();
  double offset_px = 0.0;
  double variance_px2 = 1.0;
  /// With so many others in its part of the image, which err alike.
  double sharing = 1.0;
};

/// Those of the points of a pair.
std::vector<RowObservation> RowObservationsOf(const StereoFeatures& features, const StereoCamera& camera);

/// How far an innovation may be off, in standard deviations, to be learned from.
inline constexpr double kMaxRowDeviation = 4.0;

/// Factor of the variance of an innovation of so many standard deviations (Huber).
double RowHuberFactor(double deviation);

/// Estimates, while driving, by how much rows of the right image differ from those of the left (`RowField`).
///
/// Public sequences have pairs whose rows differ by a pixel towards the corners. That costs matches, and where an
/// edge is slanted each row of it is a disparity of its own: a segment at 20 degrees to the baseline errs by 2.7 px a
/// row. Patches with corners tell the row of a match without knowing it, so this needs no motion and no depth. A
/// Kalman filter with a prior around the median of the first pair, believed only where it is significant, large
/// enough to matter, and most matches are the better for it: a good calibration is left alone. It follows slow
/// changes, of warmth, not a knock.
class RowCalibration {
 public:
  RowCalibration(const StereoCamera& camera, const RowCalibrationOptions& options);

  /// Goes on from what was learned before; before the first frame.
  void Begin(const SelfCalibration::Rows& learned);
  std::optional<SelfCalibration::Rows> learned() const {
    return used_ ? std::optional<SelfCalibration::Rows>({state_, covariance_}) : std::nullopt;
  }

  /// What is believed; zero until it is significant.
  RowField field() const { return used_ ? RowField(camera_, state_, TurnShown()) : RowField(); }

  /// No frame has had enough matches yet to tell whether rows differ. After some frames it is tried now and then
  /// only.
  bool needs_look() const {
    const bool now = n_frames_ < kFirstLooks || n_frames_ % kLookEvery == 0;
    return options_.enabled && !has_learned_ && now;
  }

  /// Learns from the matches of a frame, by what their rows differ beyond the skew of the pair. True where `field`
  /// becomes zero by it, or is not zero any more.
  bool Observe(const StereoFeatures& features, const PairSkew& skew = {});

  /// All that it goes on with, for `core/io/files/archive.h`.
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
  bool IsWorthIt() const;
  RowField::Turn TurnShown() const;

  StereoCamera camera_;
  RowCalibrationOptions options_;
  int64_t n_frames_ = 0;
  bool has_learned_ = false;
  bool used_ = false;
  RowField::Coefficients state_ = RowField::Coefficients::Zero();
  Eigen::Matrix<double, 6, 6> covariance_;
  /// How far most matches of the last frames are off, with the field and without it.
  int64_t n_compared_ = 0;
  double median_with_px_ = 0.0;
  double median_without_px_ = 0.0;
};

}  // namespace plslam::vo
