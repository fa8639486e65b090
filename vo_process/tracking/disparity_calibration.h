// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"
#include "vo_process/tracking/disparity_check.h"
#include "vo_process/tracking/self_calibration.h"
#include "vo_process/tracking/tracked_frame.h"

namespace plslam::vo {

/// Estimates, while driving, what is left of calibration errors in the disparities, and takes it away.
///
/// A yaw of 0.02 degrees between the cameras, or some distortion that the calibration missed, shifts all disparities
/// by a few tenths of a pixel: nothing to the eye, but at a disparity of 20 px a per cent of scale. The error is
/// modelled as
///
///   d_measured = d_true + b0 + b1 x + b2 x^2,   x = (u - cx) / f,
///
/// and seen by comparing the disparity of a tracked point with the one that its motion in the left image implies. The
/// motion has a scale error of its own, of which the disparities are the cause; it enters as a fourth, quickly
/// changing unknown, and is told from b0 by points at different depths. A Kalman filter with a prior around zero,
/// believed only when significant: a camera that does not move, or a good calibration, is left alone. Tracks share
/// errors that are not the camera's (corners that slide, grazing ground), so being significant is not enough:
/// `DisparityCheck` must agree.
class DisparityCalibration {
 public:
  DisparityCalibration(const StereoCamera& camera, const DisparityCalibrationOptions& options);

  /// Goes on from what was learned before, and believes it; before the first frame.
  void Begin(const SelfCalibration::Disparities& learned);
  std::optional<SelfCalibration::Disparities> learned() const;

  /// What to subtract from a disparity measured at column `u_px`, a pixel at most; 0 until it is believed.
  double Offset_px(double u_px) const;

  /// The largest error in any column, also where it is too large to be taken away; 0 until it is known.
  double Largest_px() const;

  const DisparityCheck& check() const { return check_; }

  /// Subtracts the offset from all disparities of both feature types; those that would fall to zero lose their depth.
  void Correct(StereoFeatures& features) const;

  /// Learns from the points of a tracked frame; `raw_disparities_px` are those before `Correct`, in the order of the
  /// frame's points.
  void Observe(const SE3& T_odom_c, const TrackedFrame& frame, const std::vector<double>& raw_disparities_px);

  /// After a frame that was not tracked: views from before are not compared with later ones.
  void Interrupt() {
    observations_.clear();
    check_.Interrupt();
  }

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.significant_, self.share_, self.state_, self.covariance_, self.observations_, self.check_);
  }

 private:
  bool IsBelieved() const { return significant_ && check_.verdict() == DisparityCheck::Verdict::kAgrees; }

  /// A point as seen when its present stretch of tracking began.
  struct Observation {
    int64_t landmark_id = -1;
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

  bool Compare(const Observation& before, const SE3& T_now_before, const Eigen::Vector2d& px_now,
               Measurement& measurement) const;
  void Learn(const std::vector<Measurement>& measurements);
  Eigen::Vector4d Row(double u_px, double disparity_px) const;

  StereoCamera camera_;
  DisparityCalibrationOptions options_;
  bool significant_ = false;
  /// Of the estimate that is taken away, 0 to 1: it comes and goes in a few frames, not at a stroke.
  double share_ = 0.0;
  Eigen::Vector4d state_ = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance_ = Eigen::Matrix4d::Zero();
  /// Ordered by landmark.
  std::vector<Observation> observations_;
  DisparityCheck check_;
};

}  // namespace plslam::vo
