// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/datasets/dataset.h"
#include "vo_process/options.h"
#include "vo_process/stereo/stage_timer.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::test {

/// Stored result of a frame, with the truth if the dataset has it.
struct OdometryFrame {
  int64_t t_ns = 0;
  TrackingState state = TrackingState::kInitialising;
  /// Left camera as calibrated, as in trajectory files.
  SE3 T_odom_l;
  Matrix6d covariance = Matrix6d::Zero();
  SE3 T_prev_c;
  Matrix6d motion_covariance = Matrix6d::Zero();
  std::optional<SE3> T_w_l;
  /// The vertical by the inertial sensor, in c.
  std::optional<UpDirection> up;
  SE3 T_l_c;
  bool keyframe = false;
  int n_points = 0;
  int n_lines = 0;
  int n_tracked_points = 0;
  int n_tracked_lines = 0;
  /// Moving bodies that were published so far.
  int n_bodies = 0;
  /// Estimated delay of the right images after the left ones.
  double late_s = 0.0;
  /// Readout time that was found.
  double readout_s = 0.0;
  /// Correction subtracted from disparities at the centres of the thirds of the image.
  Eigen::Vector3d disparity_offset_px = Eigen::Vector3d::Zero();
  /// Whether the inertial sensor is used after this frame, and the sentences that vo_process would publish about it.
  bool uses_imu = false;
  std::string imu_contradiction;
  std::string imu_sample_faults;
  std::vector<vo::StageTime> stages;
};

/// Runs the front end and odometry over a dataset in this process, like vo_process without messages. `visit`, if given,
/// receives each frame's complete result with its images. `first` is the first frame.
std::vector<OdometryFrame> RunOdometry(
    const Dataset& dataset, const vo::VoOptions& options, int stride = 1, int max_frames = 1 << 30,
    const std::function<void(const StereoImages&, const vo::OdometryResult&)>& visit = nullptr, int first = 0);

/// Hands the inertial samples between two frames, and some around them, to odometry that has such a sensor.
void ExpectImu(const Dataset& dataset, int64_t from_ns, int64_t to_ns, vo::Odometry& odometry);

/// Root mean square of the position error after the best rigid alignment, over frames that are not lost and have a
/// truth. Negative for fewer than 3.
double AbsoluteTrajectoryError(const std::vector<OdometryFrame>& frames);

/// Returns the scale of the path of these frames relative to that of the same frames in `whole`, after the best
/// similarity; 0 for fewer than 3.
double ScaleAgainst(const std::vector<OdometryFrame>& piece, const std::vector<OdometryFrame>& whole);

/// Mean of e^T cov^-1 e over the motions between successive tracked frames (6 if the covariance is correct), without
/// the largest hundredth, which are outliers of any Gaussian.
double MotionNees(const std::vector<OdometryFrame>& frames);

/// Mean of e^T cov^-1 e over the motions of `span` tracked frames, their covariances composed as a filter does:
/// errors that frames have in common show here.
double SpanNees(const std::vector<OdometryFrame>& frames, size_t span);

/// Error of the motion over frames `first` to `last`, in metres and radians, and its chi-square (6 if the composed
/// covariances are correct).
struct MotionError {
  double translation_m = 0.0;
  double rotation_rad = 0.0;
  double chi2 = 0.0;
  /// Composed sigma of the translation, the largest of its axes.
  double sigma_m = 0.0;
};
MotionError ErrorOfMotion(const std::vector<OdometryFrame>& frames, size_t first, size_t last);

/// Frames with state lost.
int LostFrames(const std::vector<OdometryFrame>& frames);

}  // namespace plslam::test
