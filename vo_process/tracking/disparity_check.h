// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"
#include "vo_process/tracking/tracked_frame.h"

namespace plslam::vo {

/// Of an error b0 + b1 x + b2 x^2 of the disparities, x = (u - cx) / f: what each coefficient counts at a column.
Eigen::Vector3d DisparityErrorTerms(const StereoCamera& camera, double u_px);

/// Sigmas that are expected of the coefficients, given that of b0.
Eigen::Vector3d DisparityErrorSigmas(double sigma_px);

/// Whether an error of the disparities, as `DisparityCalibration` estimates it, is one of the cameras.
///
/// Points that are seen in two pairs of images, a stretch of frames apart, tell it independently of the tracker's
/// poses: with wrong disparities no rigid motion explains both pairs. The motion of each stretch is estimated anew
/// with the coefficients of the error and eliminated, so that a pose that gave way to wrong disparities does not hide
/// them.
///
/// Corners that slide, grazing ground and moving things look like such an error, too, and do not average out. So the
/// estimate is made of halves of the points as well: odd and even landmarks, near and far ones. An error of the
/// cameras is the same for all.
class DisparityCheck {
 public:
  enum class Verdict : uint8_t {
    kUnknown,      ///< too little seen
    kAgrees,       ///< the halves do
    kContradicts,  ///< they do not: there is something else
    kTooLarge,     ///< no residue of a calibration
  };

  DisparityCheck(const StereoCamera& camera, const DisparityCalibrationOptions& options);

  /// Goes on from an estimate of another run that its check agreed with; before the first frame.
  void Begin(const Eigen::Vector3d& coefficients_px, const Eigen::Matrix3d& covariance_px2);

  Verdict verdict() const { return verdict_; }

  /// The error of disparities measured at a column, as far as it is known.
  double Estimate_px(double u_px) const;

  /// Learns from the points of a tracked frame; `raw_disparities_px` are those before any correction, in the order of
  /// the frame's points.
  void Observe(const SE3& T_odom_c, const TrackedFrame& frame, const std::vector<double>& raw_disparities_px);

  /// After a frame that was not tracked: views from before are not compared with later ones.
  void Interrupt() { begin_.clear(); }

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.verdict_, self.estimate_, self.by_landmark_, self.by_depth_, self.all_, self.n_stretches_,
      self.T_odom_begin_, self.begin_);
  }

 private:
  /// A point as one pair of images shows it.
  struct PairView {
    int64_t landmark_id = -1;
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    double disparity_px = 0.0;
    double sigma_px = 1.0;
    double sigma_disparity_px = 1.0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.landmark_id, self.px, self.disparity_px, self.sigma_px, self.sigma_disparity_px);
    }
  };
  /// Normal equations of the coefficients alone.
  struct Evidence {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.information, self.vector);
    }
  };
  /// The same of two halves of the points, each with its own motions.
  struct Division {
    Evidence first;
    Evidence second;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.first, self.second);
    }
  };
  /// Both views of a point; the first is at the beginning of the stretch.
  struct Seen {
    PairView before;
    PairView now;
    /// True disparity at the beginning, as far as it is known.
    double disparity_px = 0.0;
  };
  using Normal = Eigen::Matrix<double, 9, 10>;

  Eigen::Vector3d Row(double u_px) const;
  Eigen::Matrix3d Information(const Evidence& evidence) const;
  Eigen::Vector3d Solve(const Evidence& evidence) const;
  bool Linearise(const SE3& T_now_before, const Eigen::Vector3d& b, Seen& point, Normal& normal) const;
  void Learn(SE3 T_now_before, std::vector<Seen> points);
  double Size_px(const Eigen::Vector3d& coefficients) const;
  double Sigma_px(const Eigen::Matrix3d& covariance) const;
  bool Differ(const Division& division, double sigmas, double share) const;
  void Judge();

  StereoCamera camera_;
  DisparityCalibrationOptions options_;
  Verdict verdict_ = Verdict::kUnknown;
  Eigen::Vector3d estimate_ = Eigen::Vector3d::Zero();
  Division by_landmark_;
  Division by_depth_;
  Evidence all_;
  int64_t n_stretches_ = 0;
  SE3 T_odom_begin_;
  /// What was seen at the beginning of the present stretch, ordered by landmark.
  std::vector<PairView> begin_;
};

}  // namespace plslam::vo
