// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "vo_process/options.h"
#include "vo_process/tracking/landmarks/tracked_frame.h"

namespace plslam::vo {

/// Weights [1, x, x^2] of the coefficients of an offset b0 + b1 x + b2 x^2 at a column, x = (u - cx) / f.
Eigen::Vector3d DisparityErrorTerms(const StereoCamera& camera, double u_px);

/// Prior sigmas of the three coefficients, given that of b0.
Eigen::Vector3d DisparityErrorSigmas(double sigma_px);

/// Estimates the offset of the disparities without the tracker's poses, and tests whether it is one of the cameras.
///
/// Two stereo pairs a stretch of frames apart determine the offset: with wrong disparities no rigid motion explains
/// both. The motion of each stretch is estimated together with the coefficients and eliminated, so a tracked pose that
/// gave way to wrong disparities does not hide them.
///
/// Sliding corners, grazing ground and moving objects cause residuals that look like an offset and do not average
/// out. An offset of the cameras is the same in any half of the data, so the estimate is repeated in halves: odd and
/// even landmarks, near and far ones, odd and even stretches.
class DisparityCheck {
 public:
  enum class Verdict : uint8_t {
    kUnknown,      ///< too few stretches
    kAgrees,       ///< the halves agree
    kContradicts,  ///< the halves differ: something else causes the residuals
  };

  DisparityCheck(const StereoCamera& camera, const DisparityCalibrationOptions& options);

  /// Starts from an estimate of another run whose halves agreed; before the first frame.
  void Begin(const Eigen::Vector3d& coefficients_px, const Eigen::Matrix3d& covariance_px2);

  Verdict verdict() const { return verdict_; }

  /// Estimated coefficients of the offset.
  const Eigen::Vector3d& estimate_px() const { return estimate_; }

  /// Estimated offset of disparities measured at a column.
  double Estimate_px(double u_px) const;

  /// Whether the estimate is significant, the halves agree, and another estimate with this covariance agrees with it.
  bool Confirms(const Eigen::Vector3d& coefficients_px, const Eigen::Matrix3d& covariance_px2) const;

  /// Adds the points of a tracked frame; `raw_disparities_px` are uncorrected, in the order of the frame's points.
  void Observe(const SE3& T_odom_c, const TrackedFrame& frame, const std::vector<double>& raw_disparities_px);

  /// Ends the stretch after a frame that was not tracked.
  void Interrupt() { begin_.clear(); }

  /// The whole state, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.verdict_, self.estimate_, self.by_landmark_, self.by_depth_, self.by_time_, self.all_, self.n_stretches_,
      self.T_odom_begin_, self.begin_);
  }

 private:
  /// Measurement of a point in one stereo pair.
  struct PairView {
    TrackId landmark_id = -1;
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    double disparity_px = 0.0;
    double sigma_px = 1.0;
    double sigma_disparity_px = 1.0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.landmark_id, self.px, self.disparity_px, self.sigma_px, self.sigma_disparity_px);
    }
  };
  /// Normal equations of the coefficients, motions eliminated.
  struct Evidence {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.information, self.vector);
    }
  };
  /// Normal equations of two halves of the data, each with motions of its own.
  struct Division {
    Evidence first;
    Evidence second;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.first, self.second);
    }
  };
  /// Both views of a point: at the beginning and at the end of a stretch.
  struct Seen {
    PairView before;
    PairView now;
    /// Estimate of the true disparity at the beginning.
    double disparity_px = 0.0;
  };
  using Normal = Eigen::Matrix<double, 9, 10>;

  /// Median factor by which disparities of points have changed, at least 1.
  static double MedianChange(const std::vector<Seen>& points);
  Eigen::Vector3d Row(double u_px) const;
  Eigen::Matrix3d Information(const Evidence& evidence) const;
  Eigen::Vector3d Solve(const Evidence& evidence) const;
  bool Linearise(const SE3& T_now_before, const Eigen::Vector3d& b, double max_deviation, Seen& point,
                 Normal& normal) const;
  void Learn(SE3 T_now_before, std::vector<Seen> points);
  double Size_px(const Eigen::Vector3d& coefficients) const;
  double Sigma_px(const Eigen::Matrix3d& covariance) const;
  bool Differ(const Division& division, double share) const;
  void Decide();

  StereoCamera camera_;
  DisparityCalibrationOptions options_;
  Verdict verdict_ = Verdict::kUnknown;
  Eigen::Vector3d estimate_ = Eigen::Vector3d::Zero();
  Division by_landmark_;
  Division by_depth_;
  Division by_time_;
  Evidence all_;
  int64_t n_stretches_ = 0;
  SE3 T_odom_begin_;
  /// Views at the beginning of the present stretch, ordered by landmark.
  std::vector<PairView> begin_;
};

}  // namespace plslam::vo
