// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/odometry_run.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "tests/support/dense_algebra.h"
#include "tests/support/steady_ms.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::test {
namespace {

OdometryFrame Summarise(const vo::OdometryResult& result, const SE3& T_l_c) {
  OdometryFrame frame;
  frame.state = result.state;
  frame.T_odom_l = result.T_odom_c * T_l_c.Inverse();
  frame.covariance = result.covariance;
  frame.T_prev_c = result.T_prev_c;
  frame.motion_covariance = result.motion_covariance;
  frame.up = result.up;
  frame.T_l_c = T_l_c;
  frame.keyframe = result.keyframe.has_value();
  frame.n_points = static_cast<int>(result.features.points.size());
  frame.n_lines = static_cast<int>(result.features.lines.size());
  frame.n_tracked_points = result.n_tracked_points;
  frame.n_tracked_lines = result.n_tracked_lines;
  return frame;
}

}  // namespace

void ExpectImu(const Dataset& dataset, int64_t from_ns, int64_t to_ns, vo::Odometry& odometry) {
  constexpr int64_t kMargin_ns = 50'000'000;
  const std::vector<ImuSample>& all = dataset.ImuSamples();
  if (all.empty() || !odometry.motion().inertial().has_sensor()) return;
  const int64_t offset_ns = dataset.rig().imu->offset_ns();
  const auto after = [&](int64_t t_ns) {
    return std::lower_bound(all.begin(), all.end(), t_ns - offset_ns,
                            [](const ImuSample& sample, int64_t t) { return sample.t_ns < t; });
  };
  // In order and once each, as vo_process has them.
  std::vector<ImuSample> samples(after(from_ns - kMargin_ns), after(to_ns + kMargin_ns));
  std::stable_sort(samples.begin(), samples.end(), [](const auto& a, const auto& b) { return a.t_ns < b.t_ns; });
  const auto same = [](const auto& a, const auto& b) { return a.t_ns == b.t_ns; };
  samples.erase(std::unique(samples.begin(), samples.end(), same), samples.end());
  odometry.ExpectImu(SamplesOfMotion(samples, from_ns - offset_ns, to_ns - offset_ns), from_ns, to_ns);
}

std::vector<OdometryFrame> RunOdometry(
    const Dataset& dataset, const vo::VoOptions& options, int stride, int max_frames,
    const std::function<void(const StereoImages&, const vo::OdometryResult&)>& visit, int first) {
  vo::StereoFrontEnd front_end(dataset.rig(), options);
  vo::Odometry odometry(front_end.camera(), options, front_end.shutter(),
                        options.imu.enabled ? vo::MountedImuOf(dataset.rig()) : std::nullopt);
  const SE3 T_l_c(Rectifier(dataset.rig()).q_l_c(), Eigen::Vector3d::Zero());
  std::vector<OdometryFrame> frames;
  for (int i = first; i < dataset.size() && static_cast<int>(frames.size()) < max_frames; i += stride) {
    const StereoImages images = dataset.Read(i);
    if (!frames.empty()) ExpectImu(dataset, frames.back().t_ns, images.t_ns, odometry);
    vo::StageTimer timer(SteadyMs);
    vo::OdometryResult result;
    timer.Time("total", [&] {
      StereoFeatures features = odometry.SeePair(front_end, images, timer);
      result = timer.Time("track", [&] { return odometry.Track(images.t_ns, std::move(features)); });
    });
    OdometryFrame frame = Summarise(result, T_l_c);
    frame.t_ns = images.t_ns;
    frame.T_w_l = dataset.GroundTruth(i);
    frame.late_s = odometry.calibration().sync().late_s();
    frame.uses_imu = odometry.motion().inertial().IsTrusted();
    frame.imu_contradiction = odometry.motion().ImuContradiction();
    frame.imu_sample_faults = odometry.motion().ImuSampleFaults();
    frame.readout_s = odometry.calibration().found_readout_s();
    for (int third = 0; third < 3; ++third) {
      const double u_px = (2 * third + 1) / 6.0 * front_end.camera().width_px;
      frame.disparity_offset_px(third) = odometry.calibration().disparities().Offset_px(u_px);
    }
    frame.stages = timer.stages();
    frames.push_back(frame);
    if (visit) visit(images, result);
  }
  return frames;
}

double ScaleAgainst(const std::vector<OdometryFrame>& piece, const std::vector<OdometryFrame>& whole) {
  Eigen::Matrix3Xd a(3, 0);
  Eigen::Matrix3Xd b(3, 0);
  for (const OdometryFrame& frame : piece) {
    const auto same = std::find_if(whole.begin(), whole.end(), [&](const auto& f) { return f.t_ns == frame.t_ns; });
    if (same == whole.end()) continue;
    a.conservativeResize(Eigen::NoChange, a.cols() + 1);
    b.conservativeResize(Eigen::NoChange, b.cols() + 1);
    a.rightCols<1>() = same->T_odom_l.translation();
    b.rightCols<1>() = frame.T_odom_l.translation();
  }
  if (a.cols() < 3) return 0.0;
  return std::cbrt(Eigen::umeyama(a, b, true).topLeftCorner<3, 3>().determinant());
}

double AbsoluteTrajectoryError(const std::vector<OdometryFrame>& frames) {
  std::vector<Eigen::Vector3d> estimate;
  std::vector<Eigen::Vector3d> truth;
  for (const OdometryFrame& frame : frames) {
    if (!frame.T_w_l || frame.state == TrackingState::kLost || frame.state == TrackingState::kInitialising) continue;
    estimate.push_back(frame.T_odom_l.translation());
    truth.push_back(frame.T_w_l->translation());
  }
  const int n = static_cast<int>(estimate.size());
  if (n < 3) return -1.0;
  Eigen::Matrix3Xd a(3, n);
  Eigen::Matrix3Xd b(3, n);
  for (int i = 0; i < n; ++i) {
    a.col(i) = estimate[i];
    b.col(i) = truth[i];
  }
  const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
  const Eigen::Matrix3Xd error = ((T.topLeftCorner<3, 3>() * a).colwise() + T.topRightCorner<3, 1>().eval()) - b;
  return std::sqrt(error.colwise().squaredNorm().mean());
}

double MotionNees(const std::vector<OdometryFrame>& frames) {
  std::vector<double> values;
  for (size_t i = 1; i < frames.size(); ++i) {
    const OdometryFrame& previous = frames[i - 1];
    const OdometryFrame& frame = frames[i];
    if (!frame.T_w_l || !previous.T_w_l || frame.state != TrackingState::kTracking) continue;
    const SE3 truth = frame.T_l_c.Inverse() * (previous.T_w_l->Inverse() * *frame.T_w_l) * frame.T_l_c;
    const Vector6d error = (frame.T_prev_c.Inverse() * truth).Log();
    values.push_back(ChiSquare(error, frame.motion_covariance));
  }
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  values.resize(std::max<size_t>(1, values.size() - values.size() / 100));
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double SpanNees(const std::vector<OdometryFrame>& frames, size_t span) {
  double sum = 0.0;
  int n = 0;
  for (size_t last = span; last < frames.size(); ++last) {
    const OdometryFrame& first = frames[last - span];
    const OdometryFrame& frame = frames[last];
    SE3 motion;
    Matrix6d covariance = Matrix6d::Zero();
    bool tracked = first.T_w_l && frame.T_w_l;
    for (size_t i = last - span + 1; i <= last; ++i) {
      tracked = tracked && frames[i].state == TrackingState::kTracking;
      covariance = ComposeCovariance(covariance, frames[i].T_prev_c, frames[i].motion_covariance);
      motion = motion * frames[i].T_prev_c;
    }
    if (!tracked) continue;
    const SE3 truth = frame.T_l_c.Inverse() * (first.T_w_l->Inverse() * *frame.T_w_l) * frame.T_l_c;
    sum += ChiSquare((motion.Inverse() * truth).Log(), covariance);
    ++n;
  }
  return n == 0 ? 0.0 : sum / n;
}

MotionError ErrorOfMotion(const std::vector<OdometryFrame>& frames, size_t first, size_t last) {
  SE3 motion;
  Matrix6d covariance = Matrix6d::Zero();
  for (size_t i = first + 1; i <= last; ++i) {
    covariance = ComposeCovariance(covariance, frames[i].T_prev_c, frames[i].motion_covariance);
    motion = motion * frames[i].T_prev_c;
  }
  const SE3 truth =
      frames[last].T_l_c.Inverse() * (frames[first].T_w_l->Inverse() * *frames[last].T_w_l) * frames[last].T_l_c;
  const Vector6d error = (motion.Inverse() * truth).Log();
  return {error.head<3>().norm(), error.tail<3>().norm(), ChiSquare(error, covariance),
          std::sqrt(covariance.diagonal().head<3>().maxCoeff())};
}

int LostFrames(const std::vector<OdometryFrame>& frames) {
  return static_cast<int>(std::count_if(
      frames.begin(), frames.end(), [](const OdometryFrame& frame) { return frame.state == TrackingState::kLost; }));
}

}  // namespace plslam::test
