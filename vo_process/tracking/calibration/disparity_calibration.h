// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "vo_process/options.h"
#include "vo_process/tracking/calibration/disparity_check.h"
#include "vo_process/tracking/calibration/self_calibration.h"
#include "vo_process/tracking/landmarks/tracked_frame.h"

namespace plslam::vo {

/// Estimates the offset of the disparities while driving, and corrects for it once it is proved.
///
/// A yaw of 0.02 degrees between the cameras, or a distortion that the calibration missed, shifts all disparities by a
/// few tenths of a pixel; at a disparity of 10 px, 1 px changes lengths by 10 %. The model is
///
///   d_measured = d_true + b0 + b1 x + b2 x^2,   x = (u - cx) / f.
///
/// A Kalman filter compares the disparity of each tracked point with the one that its motion in the left image
/// implies. The tracked motion has a scale error, caused by the offset itself; it is a fourth, quickly changing state,
/// and points at different depths distinguish it from b0.
///
/// Tracks have common errors that are not the camera's (sliding corners, grazing ground), so significance is not
/// enough: the offset is applied, whatever its size, while `DisparityCheck`, which does not use the tracked poses,
/// confirms it. Otherwise its size is part of the uncertainty of lengths (`LengthSigma`).
class DisparityCalibration {
 public:
  /// Relative change of lengths that the applied offset would cause without correction, at the median depths of the
  /// tracked frames: 0.1 is 10 % too long.
  struct LengthError {
    double share = 0.0;
    double sigma = 0.0;
  };

  DisparityCalibration(const StereoCamera& camera, const DisparityCalibrationOptions& options);

  /// Starts with the estimate of an earlier run, and applies it; before the first frame.
  void Begin(const SelfCalibration::Disparities& learned);
  /// The applied estimate; nullopt while none is applied.
  std::optional<SelfCalibration::Disparities> learned() const;

  bool is_applied() const { return applied_; }

  /// Whether more independent measurements would decide what matters: lengths depend by more than half a percent on what
  /// is unknown of an applied offset, or by more than two on a significant one that is not confirmed yet.
  bool NeedsMeasurements() const;

  /// Applied offset of a disparity measured at column `u_px`; 0 while none is applied.
  double Offset_px(double u_px) const;

  /// Offset that remains after correction, at a column.
  struct Rest {
    double mean_px = 0.0;
    double sigma_px = 0.0;
  };
  Rest RestAt(double u_px) const;

  /// The applied error of lengths; nullopt while none is applied.
  std::optional<LengthError> length_error() const;

  /// Relative sigma of lengths due to the unknown rest, at the depths of the last tracked frame.
  double LengthSigma() const { return length_sigma_; }

  const DisparityCheck& check() const { return check_; }

  /// Subtracts the offset from all disparities of both feature types; those that would fall to zero lose their depth.
  void Correct(StereoFeatures& features) const;

  /// Adds the points of a tracked frame; `raw_disparities_px` are those before `Correct`, in the order of the frame's
  /// points. Returns whether an offset is applied now that was not before, or no longer.
  bool Observe(const SE3& T_odom_c, const TrackedFrame& frame, const std::vector<double>& raw_disparities_px);

  /// Ends all tracks after a frame that was not tracked.
  void Interrupt() {
    observations_.clear();
    check_.Interrupt();
  }

  /// The whole state, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.applied_, self.length_sigma_, self.length_terms_, self.n_measured_, self.state_, self.covariance_,
      self.observations_, self.check_);
  }

 private:
  /// Measurement of a point at the beginning of its present stretch.
  struct Observation {
    TrackId landmark_id = -1;
    SE3 T_odom_c;
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    double disparity_px = 0.0;
    double sigma_px = 1.0;
    double sigma_disparity_px = 1.0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.landmark_id, self.T_odom_c, self.px, self.disparity_px, self.sigma_px, self.sigma_disparity_px);
    }
  };
  struct Measurement {
    double u_px = 0.0;
    double mean_px = 0.0;
    double residual_px = 0.0;
    double variance_px2 = 1.0;
  };

  bool IsSignificant() const;
  bool Compare(const Observation& before, const SE3& T_now_before, const Eigen::Vector2d& px_now,
               Measurement& measurement) const;
  void Learn(const std::vector<Measurement>& measurements);
  Eigen::Vector4d Row(double u_px, double disparity_px) const;
  double Estimate_px(double u_px) const { return Row(u_px, 0.0).dot(state_); }
  /// Sigma of the estimate times the terms: of `DisparityErrorTerms` at a column, or a sum of such.
  double EstimateSigma_px(const Eigen::Vector3d& terms) const;
  void MeasureLengths(const TrackedFrame& frame, const std::vector<double>& raw_disparities_px);

  StereoCamera camera_;
  DisparityCalibrationOptions options_;
  bool applied_ = false;
  double length_sigma_ = 0.0;
  /// Mean over the tracked frames of the terms of the offset, divided by the median disparity.
  Eigen::Vector3d length_terms_ = Eigen::Vector3d::Zero();
  int64_t n_measured_ = 0;
  /// b0, b1, b2 in pixels, and the relative scale error of the tracked motion.
  Eigen::Vector4d state_ = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance_ = Eigen::Matrix4d::Zero();
  /// Ordered by landmark.
  std::vector<Observation> observations_;
  DisparityCheck check_;
};

}  // namespace plslam::vo
