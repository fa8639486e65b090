// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/disparity_calibration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "core/geometry/hypot.h"
#include "core/geometry/symmetric.h"
#include "core/motion/robust.h"
#include "vo_process/stereo/row_field.h"

namespace plslam::vo {
namespace {

// Errors of lengths that are worth more detected features.
constexpr double kMostAppliedRest = 0.005;
constexpr double kMostSuspected = 0.02;

// Sigma of the disparity implied by parallax below which a point is compared.
constexpr double kMaxImpliedSigma_px = 0.7;
// Comparisons of one frame share the errors of its pose: they count as at most this number of independent ones.
constexpr double kIndependentPerFrame = 30.0;
constexpr double kMaxDeviation = 4.0;
constexpr double kHuber = 1.5;
constexpr int kIterations = 4;
// Sigma of the scale error in the first frame, and of its change from frame to frame.
constexpr double kScaleSigma = 0.02;
constexpr double kScaleDrift = 0.003;
// Change of b0 between runs (temperature, and errors that the scenes of one run have in common).
constexpr double kBetweenRuns_px = 0.03;
// Sigma of the offsets of usual rigs (KITTI, EuRoC, TUM VI).
constexpr double kUsual_px = 0.3;

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
  applied_ = true;
}

std::optional<SelfCalibration::Disparities> DisparityCalibration::learned() const {
  if (!applied_) return std::nullopt;
  return SelfCalibration::Disparities{state_.head<3>(), covariance_.topLeftCorner<3, 3>()};
}

Eigen::Vector4d DisparityCalibration::Row(double u_px, double disparity_px) const {
  Eigen::Vector4d row;
  row << DisparityErrorTerms(camera_, u_px), disparity_px;
  return row;
}

double DisparityCalibration::Offset_px(double u_px) const { return applied_ ? Estimate_px(u_px) : 0.0; }

// The covariance contains only noise; half of the difference of the two estimates shows errors that tracks share.
double DisparityCalibration::EstimateSigma_px(const Eigen::Vector3d& terms) const {
  const double variance_px2 = terms.dot(covariance_.topLeftCorner<3, 3>() * terms);
  const double half_px = applied_ ? 0.5 * terms.dot(state_.head<3>() - check_.estimate_px()) : 0.0;
  return std::sqrt(variance_px2 + half_px * half_px);
}

// Posterior with the prior of usual rigs instead of the wide prior of the filter.
DisparityCalibration::Rest DisparityCalibration::RestAt(double u_px) const {
  const double sigma_px = EstimateSigma_px(DisparityErrorTerms(camera_, u_px));
  const double variance = sigma_px * sigma_px;
  const double gain = kUsual_px * kUsual_px / (kUsual_px * kUsual_px + variance);
  return {applied_ ? 0.0 : gain * Estimate_px(u_px), std::sqrt(gain * variance)};
}

std::optional<DisparityCalibration::LengthError> DisparityCalibration::length_error() const {
  if (!applied_) return std::nullopt;
  return LengthError{-length_terms_.dot(state_.head<3>()), EstimateSigma_px(length_terms_)};
}

bool DisparityCalibration::IsSignificant() const {
  return SquaredMahalanobis<3>(state_.head<3>(), covariance_.topLeftCorner<3, 3>()) > options_.min_chi_square;
}

bool DisparityCalibration::NeedsMeasurements() const {
  if (!options_.enabled) return false;
  return applied_ ? length_sigma_ > kMostAppliedRest : length_sigma_ > kMostSuspected && IsSignificant();
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
  // Gauss-Newton on the inverse depth, with a constant pose.
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
  // The error of the weighted mean is independent of that of the residual; any other mean would put noise into the
  // scale state.
  measurement.mean_px =
      (implied_variance * before.disparity_px + seen_variance * implied_px) / measurement.variance_px2;
  return std::isfinite(measurement.residual_px);
}

bool DisparityCalibration::Observe(const SE3& T_odom_c, const TrackedFrame& frame,
                                   const std::vector<double>& raw_disparities_px) {
  if (!options_.enabled) return false;
  std::vector<Observation> now;
  check_.Observe(T_odom_c, frame, raw_disparities_px);
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    const StereoPoint& point = frame.features.points[i];
    // Points of moving bodies have another motion.
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
      observation = *before;  // the stretch continues until there is enough parallax
    }
  }
  observations_ = std::move(now);
  Learn(measurements);
  const bool applied = IsSignificant() && check_.Confirms(state_.head<3>(), covariance_.topLeftCorner<3, 3>());
  const bool changed = std::exchange(applied_, applied) != applied;
  MeasureLengths(frame, raw_disparities_px);
  return changed;
}

void DisparityCalibration::MeasureLengths(const TrackedFrame& frame, const std::vector<double>& raw_disparities_px) {
  std::vector<double> sigmas;
  std::vector<double> disparities_px;
  Eigen::Vector3d terms = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    const StereoPoint& point = frame.features.points[i];
    const bool is_matched = raw_disparities_px[i] > 0.0 && point.sigma_row_px >= 0.0;
    if (frame.point_tracks[i].landmark_id < 0 || !is_matched || !frame.point_tracks[i].IsOfWorld()) continue;
    const double u_px = point.left.px.x();
    const Rest rest = RestAt(u_px);
    sigmas.push_back(Hypot(rest.mean_px, rest.sigma_px) / raw_disparities_px[i]);
    disparities_px.push_back(raw_disparities_px[i]);
    terms += DisparityErrorTerms(camera_, u_px);
  }
  if (sigmas.empty()) return;
  length_sigma_ = Median(sigmas);
  terms /= static_cast<double>(disparities_px.size()) * Median(disparities_px);
  length_terms_ += (terms - length_terms_) / static_cast<double>(++n_measured_);
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
}

}  // namespace plslam::vo
