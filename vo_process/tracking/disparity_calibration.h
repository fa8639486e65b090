#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"
#include "vo_process/tracking/tracked_frame.h"

namespace plslam {

/// Estimates, while driving, what is left of calibration errors in the disparities, and takes it away.
///
/// A yaw of 0.02 degrees between the cameras, or some distortion that the calibration missed, shifts all disparities by
/// a few tenths of a pixel: nothing to the eye, but at a disparity of 20 px a per cent of scale. The error is modelled as
///
///   d_measured = d_true + b0 + b1 x + b2 x^2,   x = (u - cx) / f.
///
/// Points that are seen in two pairs of images, a stretch of frames apart, tell it: with wrong disparities no rigid motion
/// explains both pairs. The motion of each stretch is estimated anew with the coefficients and eliminated, so that a pose that
/// gave way to wrong disparities does not hide them.
///
/// Corners that slide, grazing ground and moving things look like such an error, too, and do not average out. So the
/// estimate is made of halves of the points as well: odd and even landmarks, near and far ones, and every other stretch. An
/// error of the camera is the same for all; what the halves differ by is added to the covariance. The estimate is believed
/// as far as it is significant, and as far as what remains uncertain of it hardly matters for the scale: little by little, and
/// a good calibration, or a camera that does not move, is left alone.
class DisparityCalibration {
 public:
  DisparityCalibration(const StereoCamera& camera, const DisparityCalibrationOptions& options);

  /// What to subtract from a disparity measured at column `u_px`: a pixel at most.
  double Offset_px(double u_px) const;

  /// The error of disparities measured there as far as it is known, also where it is too large to be taken away; 0 until then.
  double Known_px(double u_px) const;

  /// The largest of these in any column.
  double Largest_px() const;

  /// Subtracts the offset from all disparities of both kinds; those that would fall to zero lose their depth.
  void Correct(StereoFeatures& features) const;

  /// Learns from the points of a tracked frame; `raw_disparities_px` are those before `Correct`, in the order of the
  /// frame's points.
  void Observe(const SE3& T_odom_c, const TrackedFrame& frame, const std::vector<double>& raw_disparities_px);

  /// After a frame that was not tracked: views from before are not compared with later ones.
  void Interrupt() { begin_.clear(); }

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.is_known_, self.share_, self.estimate_, self.by_landmark_, self.by_depth_, self.by_stretch_,
      self.n_stretches_, self.disparity_px_, self.T_odom_begin_, self.begin_);
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
  Evidence AllEvidence() const;
  bool Linearise(const SE3& T_now_before, const Eigen::Vector3d& b, Seen& point, Normal& normal) const;
  void Learn(SE3 T_now_before, std::vector<Seen> points);
  void Judge();

  StereoCamera camera_;
  DisparityCalibrationOptions options_;
  bool is_known_ = false;
  /// Of the estimate that is taken away, 0 to 1.
  double share_ = 0.0;
  Eigen::Vector3d estimate_ = Eigen::Vector3d::Zero();
  Division by_landmark_;
  Division by_depth_;
  /// Both halves together are all there is.
  Division by_stretch_;
  int64_t n_stretches_ = 0;
  /// Mean over stretches of the median disparity.
  double disparity_px_ = 0.0;
  SE3 T_odom_begin_;
  /// What was seen at the beginning of the present stretch, ordered by landmark.
  std::vector<PairView> begin_;
};

}  // namespace plslam
