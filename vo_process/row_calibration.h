#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/features/features.h"
#include "core/features/row_field.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"

namespace plslam {

/// Estimates, while driving, by how much rows of the right image differ from those of the left (`RowField`).
///
/// Public sequences have pairs whose rows differ by a pixel towards the corners. That costs matches, and where an edge
/// is slanted each row of it is a disparity of its own: a segment at 20 degrees to the baseline errs by 2.7 px a row. Patches
/// with corners tell the row of a match without knowing it, so this needs no motion and no depth. A Kalman filter with a
/// prior around the median of the first pair, believed only where it is significant, large enough to
/// matter, and most matches are the better for it: a good calibration is left alone.
class RowCalibration {
 public:
  RowCalibration(const StereoCamera& camera, const RowCalibrationOptions& options);

  /// What is believed; zero until it is significant.
  RowField field() const { return used_ ? RowField(camera_, state_) : RowField(); }

  /// From enough matches to tell whether rows differ; or there was little to see in so many frames that it gives up waiting.
  bool has_learned() const { return n_learned_ >= kEnough || n_frames_ >= kMaxFrames || !options_.enabled; }

  /// Learns from the matches of a frame. True where `field` was zero before and is not any more.
  bool Observe(const StereoFeatures& features);

  /// All that it goes on with, for `core/io/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.n_frames_, self.n_learned_, self.used_, self.state_, self.covariance_, self.n_compared_,
      self.median_with_px_, self.median_without_px_);
  }

 private:
  static constexpr int64_t kEnough = 50;
  static constexpr int64_t kMaxFrames = 10;

  /// A match that tells its row.
  struct RowSight {
    RowField::Coefficients terms;
    double offset_px = 0.0;
    double variance_px2 = 1.0;
    /// With so many others in its part of the image.
    double sharing = 1.0;
  };

  std::vector<RowSight> SightsOf(const StereoFeatures& features) const;
  void Learn(const RowSight& sight);
  void Compare(const std::vector<RowSight>& sights);
  bool IsWorthIt() const;

  StereoCamera camera_;
  RowCalibrationOptions options_;
  /// With points in them, and their matches that told their rows.
  int64_t n_frames_ = 0;
  int64_t n_learned_ = 0;
  bool used_ = false;
  RowField::Coefficients state_ = RowField::Coefficients::Zero();
  Eigen::Matrix<double, 6, 6> covariance_;
  /// How far most matches of the last frames are off, with the field and without it.
  int64_t n_compared_ = 0;
  double median_with_px_ = 0.0;
  double median_without_px_ = 0.0;
};

}  // namespace plslam
