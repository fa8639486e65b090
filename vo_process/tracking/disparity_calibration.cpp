// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/disparity_calibration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "vo_process/stereo/row_field.h"

namespace plslam::vo {
namespace {

// A comparison is made as soon as parallax fixes the disparity to this sigma.
constexpr double kMaxImpliedSigma_px = 0.7;
// Comparisons of one frame share the errors of its pose: they count as at most so many independent ones.
constexpr double kIndependentPerFrame = 30.0;
constexpr double kMaxDeviation = 4.0;
constexpr double kHuber = 1.5;
constexpr int kIterations = 4;
// Sigmas of the scale error: at first, and of its change from frame to frame.
constexpr double kScaleSigma = 0.02;
constexpr double kScaleDrift = 0.003;
// How fast an estimate that is believed is taken away.
constexpr double kShareOfAFrame = 0.5;
// Sigma of b0 that is added to what was learned in another run: of warmth, and of what its scenes had in common.
constexpr double kBetweenRuns_px = 0.03;
// More is no residue of a calibration.
constexpr double kMostTaken_px = 1.0;

}  // namespace

DisparityCalibration::DisparityCalibration(const StereoCamera& camera, const DisparityCalibrationOptions& options)
    : camera_(camera), options_(options), check_(camera, options) {
  covariance_.diagonal() << DisparityErrorSigmas(options.prior_sigma_px).cwiseAbs2(), kScaleSigma * kScaleSigma;
}

void DisparityCalibration::Begin(const SelfCalibration::Disparities& learned) {
  if (!options_.enabled) return;
  Eigen::Matrix3d covariance = learned.covariance_px2;
  covariance.diagonal() += DisparityErrorSigmas(kBetweenRuns_px).cwiseAbs2();
  state_.head<3>() = learned.coefficients_px;
  covariance_.topLeftCorner<3, 3>() = covariance;
  check_.Begin(learned.coefficients_px, covariance);
  significant_ = true;
  share_ = 1.0;
}

std::optional<SelfCalibration::Disparities> DisparityCalibration::learned() const {
  if (!IsBelieved()) return std::nullopt;
  return SelfCalibration::Disparities{state_.head<3>(), covariance_.topLeftCorner<3, 3>()};
}

Eigen::Vector4d DisparityCalibration::Row(double u_px, double disparity_px) const {
  Eigen::Vector4d row;
  row << DisparityErrorTerms(camera_, u_px), disparity_px;
  return row;
}

double DisparityCalibration::Offset_px(double u_px) const {
  return share_ == 0.0 ? 0.0 : share_ * std::clamp(Row(u_px, 0.0).dot(state_), -kMostTaken_px, kMostTaken_px);
}

double DisparityCalibration::Largest_px() const {
  double largest_px = 0.0;
  for (const double u_px : {0.0, 0.5 * camera_.width_px, 1.0 * camera_.width_px}) {
    const bool too_large = check_.verdict() == DisparityCheck::Verdict::kTooLarge;
    const double error_px = too_large ? check_.Estimate_px(u_px) : IsBelieved() ? Row(u_px, 0.0).dot(state_) : 0.0;
    largest_px = std::max(largest_px, std::abs(error_px));
  }
  return largest_px;
}

void DisparityCalibration::Correct(StereoFeatures& features) const {
  CorrectDisparities(features, [this](const Eigen::Vector2d& left_px, double) { return Offset_px(left_px.x()); });
}

bool DisparityCalibration::Compare(const Observation& before, const SE3& T_now_before, const Eigen::Vector2d& px_now,
                                   Measurement& measurement) const {
  const Eigen::Vector3d ray((before.px.x() - camera_.cx_px) / camera_.f_px,
                            (before.px.y() - camera_.cy_px) / camera_.f_px, 1.0);
  const Eigen::Vector3d turned = T_now_before.rotation() * ray;
  const Eigen::Vector3d& t = T_now_before.translation();
  // Gauss-Newton on the inverse depth alone: the pose is what it is.
  double inverse_depth = before.disparity_px / camera_.FocalBaseline();
  double information = 0.0;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::Vector3d p = turned + inverse_depth * t;
    if (p.z() < camera_.MinDepth() * inverse_depth || p.z() <= 0.0) return false;
    const Eigen::Vector2d J = camera_.f_px / (p.z() * p.z()) *
                              Eigen::Vector2d(t.x() * p.z() - p.x() * t.z(), t.y() * p.z() - p.y() * t.z());
    information = J.squaredNorm();
    if (information <= 0.0) return false;
    inverse_depth += J.dot(px_now - camera_.Project(p)) / information;
  }
  const double implied_sigma_px = M_SQRT2 * before.sigma_px / std::sqrt(information) * camera_.FocalBaseline();
  if (!(implied_sigma_px < kMaxImpliedSigma_px)) return false;
  measurement.u_px = before.px.x();
  const double implied_px = inverse_depth * camera_.FocalBaseline();
  const double implied_variance = implied_sigma_px * implied_sigma_px;
  const double seen_variance = before.sigma_disparity_px * before.sigma_disparity_px;
  measurement.residual_px = before.disparity_px - implied_px;
  measurement.variance_px2 = implied_variance + seen_variance;
  // The mean by weight is the one combination whose error is independent of the residual's; with any other the scale
  // would take up noise.
  measurement.mean_px =
      (implied_variance * before.disparity_px + seen_variance * implied_px) / measurement.variance_px2;
  return std::isfinite(measurement.residual_px);
}

void DisparityCalibration::Observe(const SE3& T_odom_c, const TrackedFrame& frame,
                                   const std::vector<double>& raw_disparities_px) {
  if (!options_.enabled) return;
  std::vector<Observation> now;
  check_.Observe(T_odom_c, frame, raw_disparities_px);
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    const StereoPoint& point = frame.features.points[i];
    // What moves tells nothing of the cameras.
    const FeatureTrack& track = frame.point_tracks[i];
    if (track.landmark_id < 0 || !track.IsOfWorld() || raw_disparities_px[i] <= 0.0) continue;
    now.push_back({frame.point_tracks[i].landmark_id, T_odom_c, point.left.px, raw_disparities_px[i], point.sigma_px,
                   point.sigma_disparity_px});
  }
  const auto by_id = [](const Observation& a, const Observation& b) { return a.landmark_id < b.landmark_id; };
  std::sort(now.begin(), now.end(), by_id);
  const SE3 T_c_odom = T_odom_c.Inverse();
  std::vector<Measurement> measurements;
  for (Observation& observation : now) {
    const auto before = std::lower_bound(observations_.begin(), observations_.end(), observation, by_id);
    if (before == observations_.end() || before->landmark_id != observation.landmark_id) continue;
    Measurement measurement;
    if (Compare(*before, T_c_odom * before->T_odom_c, observation.px, measurement)) {
      measurements.push_back(measurement);
    } else {
      observation = *before;  // not enough parallax yet: the stretch goes on
    }
  }
  observations_ = std::move(now);
  Learn(measurements);
}

void DisparityCalibration::Learn(const std::vector<Measurement>& measurements) {
  covariance_(3, 3) += kScaleDrift * kScaleDrift;
  const double sharing = std::max(1.0, static_cast<double>(measurements.size()) / kIndependentPerFrame);
  for (const Measurement& m : measurements) {
    const Eigen::Vector4d row = Row(m.u_px, m.mean_px);
    const double innovation = m.residual_px - row.dot(state_);
    const Eigen::Vector4d gain = covariance_ * row;
    const double deviation = std::abs(innovation) / std::sqrt(m.variance_px2 + row.dot(gain));
    if (deviation > kMaxDeviation) continue;
    const double variance = sharing * m.variance_px2 * std::max(1.0, deviation / kHuber);
    const double total = variance + row.dot(gain);
    state_ += innovation / total * gain;
    covariance_ -= gain * gain.transpose() / total;
  }
  const Eigen::Vector3d offset = state_.head<3>();
  const Eigen::Matrix3d uncertainty = covariance_.topLeftCorner<3, 3>();
  significant_ = offset.dot(uncertainty.ldlt().solve(offset)) > options_.min_chi_square;
  share_ = std::clamp(share_ + (IsBelieved() ? kShareOfAFrame : -kShareOfAFrame), 0.0, 1.0);
}

}  // namespace plslam::vo
