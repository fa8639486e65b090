// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/disparity_check.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "core/geometry/hypot.h"
#include "core/geometry/symmetric.h"
#include "core/motion/robust.h"

namespace plslam::vo {
namespace {

// A stretch ends when this share of its points is left, or when their median disparity has changed by this factor: long
// stretches have more parallax. With the fewest points, halves still have three times as many equations as unknowns; a
// vehicle that hides most of the view leaves no more.
constexpr double kShareLeft = 0.5;
constexpr double kDisparityChange = 1.25;
constexpr size_t kMinPoints = 20;
// Most new landmarks are not tracked again, and would end stretches early.
constexpr int kMinAge = 1;
constexpr int kIterations = 5;
// Before a large offset is estimated, all points deviate, so the first iterations reject none.
constexpr int kRejectingIterations = 3;
// Norm of the three whitened residuals of a point.
constexpr double kHuber = 2.5;
constexpr double kMaxDeviation = 5.0;
// Prior sigma of b0. A narrow prior would pull the half with less evidence towards zero, so that halves that agree seem
// to differ.
constexpr double kPriorSigma_px = 0.5;
// Stretches before the first verdict.
constexpr int64_t kMinStretches = 3;
// Halves differ if half of their difference exceeds this number of sigmas and this share of the estimate.
constexpr double kDifferSigmas = 3.0;
constexpr double kDifferShare = 0.3;
// Errors common to a few frames (such as vibration) average out slowly: stretches may differ by this factor more than
// points.
constexpr double kTimeFactor = 1.7;
// Columns at which estimates are compared: the centres of the thirds of the image.
constexpr double kThirds[] = {1.0 / 6.0, 0.5, 5.0 / 6.0};

using Motion = Eigen::Matrix<double, 6, 1>;

/// Eliminates the motion from normal equations of three coefficients and a motion, and adds the rest to `evidence`.
template <class Evidence, class Normal>
bool AddWithoutMotion(const Normal& normal, const Eigen::Vector3d& b, Evidence& evidence) {
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> motion(normal.template block<6, 6>(3, 3));
  if (motion.info() != Eigen::Success || !motion.isPositive() || !(motion.rcond() > 1e-12)) return false;
  const Eigen::Matrix<double, 3, 6> cross = normal.template block<3, 6>(0, 3);
  const Eigen::Matrix3d information =
      normal.template block<3, 3>(0, 0) - cross * motion.solve(Eigen::Matrix<double, 6, 3>(cross.transpose()));
  evidence.information += information;
  evidence.vector += information * b + normal.template block<3, 1>(0, 9) -
                     cross * motion.solve(Motion(normal.template block<6, 1>(3, 9)));
  return true;
}

}  // namespace

Eigen::Vector3d DisparityErrorTerms(const StereoCamera& camera, double u_px) {
  const double x = (u_px - camera.cx_px) / camera.f_px;
  return {1.0, x, x * x};
}

Eigen::Vector3d DisparityErrorSigmas(double sigma_px) {
  constexpr double kLinearShare = 0.5;
  constexpr double kSquareShare = 2.0;
  return {sigma_px, kLinearShare * sigma_px, kSquareShare * sigma_px};
}

DisparityCheck::DisparityCheck(const StereoCamera& camera, const DisparityCalibrationOptions& options)
    : camera_(camera), options_(options) {}

/// Replaces the stretches that a verdict needs by the given estimate, shared equally by both halves.
void DisparityCheck::Begin(const Eigen::Vector3d& coefficients_px, const Eigen::Matrix3d& covariance_px2) {
  all_.information = covariance_px2.inverse();
  all_.vector = all_.information * coefficients_px;
  const Evidence half{0.5 * all_.information, 0.5 * all_.vector};
  by_landmark_ = by_depth_ = by_time_ = {half, half};
  n_stretches_ = kMinStretches;
  estimate_ = coefficients_px;
  verdict_ = Verdict::kAgrees;
}

Eigen::Vector3d DisparityCheck::Row(double u_px) const { return DisparityErrorTerms(camera_, u_px); }

double DisparityCheck::Estimate_px(double u_px) const { return Row(u_px).dot(estimate_); }

void DisparityCheck::Observe(const SE3& T_odom_c, const TrackedFrame& frame,
                             const std::vector<double>& raw_disparities_px) {
  if (!options_.enabled) return;
  std::vector<PairView> now;
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    const StereoPoint& point = frame.features.points[i];
    const FeatureTrack& track = frame.point_tracks[i];
    // Only matched points of the world: disparities of a depth camera have different errors.
    const bool is_matched = raw_disparities_px[i] > 0.0 && point.sigma_row_px >= 0.0;
    if (track.landmark_id < 0 || track.age < kMinAge || !is_matched || !track.IsOfWorld()) continue;
    now.push_back(
        {track.landmark_id, point.left.px, raw_disparities_px[i], point.sigma_px, point.sigma_disparity_px});
  }
  const auto by_id = [](const PairView& a, const PairView& b) { return a.landmark_id < b.landmark_id; };
  std::sort(now.begin(), now.end(), by_id);
  std::vector<Seen> both;
  for (const PairView& view : now) {
    const auto before = std::lower_bound(begin_.begin(), begin_.end(), view, by_id);
    if (before == begin_.end() || before->landmark_id != view.landmark_id) continue;
    both.push_back({*before, view});
  }
  const bool many_left = static_cast<double>(both.size()) > kShareLeft * static_cast<double>(begin_.size());
  if (many_left && MedianChange(both) < kDisparityChange) return;
  if (both.size() >= kMinPoints) Learn(T_odom_c.Inverse() * T_odom_begin_, std::move(both));
  T_odom_begin_ = T_odom_c;
  begin_ = std::move(now);
}

/// Adds a point to the normal equations of coefficients and motion (left perturbation of rotation, then translation),
/// after improving and eliminating its disparity. Columns of `normal`: the matrix, and the vector.
bool DisparityCheck::Linearise(const SE3& T_now_before, const Eigen::Vector3d& b, double max_deviation, Seen& point,
                               Normal& normal) const {
  const PairView& before = point.before;
  const PairView& now = point.now;
  const double fb = camera_.FocalBaseline();
  const double f = camera_.f_px;
  const Eigen::Vector3d& t = T_now_before.translation();
  const Eigen::Vector3d turned = T_now_before.rotation() * Eigen::Vector3d((before.px.x() - camera_.cx_px) / f,
                                                                           (before.px.y() - camera_.cy_px) / f, 1.0);
  const double sigma_px = Hypot(before.sigma_px, now.sigma_px);
  const Eigen::Vector4d weights(1.0 / before.sigma_disparity_px, 1.0 / sigma_px, 1.0 / sigma_px,
                                1.0 / now.sigma_disparity_px);
  Eigen::Vector4d residual;
  Eigen::Vector4d by_disparity;
  Eigen::Matrix<double, 4, 9> by_all;
  double& d = point.disparity_px;
  for (int i = 0; i < 2; ++i) {
    // The point divided by its depth at the beginning.
    const Eigen::Vector3d p = turned + d / fb * t;
    if (!(d > 0.0 && p.z() > 0.1)) return false;
    const double d_now = d / p.z();
    residual << before.disparity_px - d - Row(before.px.x()).dot(b), now.px - camera_.Project(p),
        now.disparity_px - d_now - Row(now.px.x()).dot(b);
    Eigen::Matrix<double, 3, 3> by_p;
    by_p << f / p.z(), 0.0, -f * p.x() / (p.z() * p.z()),  //
        0.0, f / p.z(), -f * p.y() / (p.z() * p.z()),      //
        0.0, 0.0, -d_now / p.z();
    by_disparity << 1.0, by_p * t / fb;
    by_disparity(3) += 1.0 / p.z();
    by_disparity = by_disparity.cwiseProduct(weights);
    residual = residual.cwiseProduct(weights);
    if (i == 0) {
      d += by_disparity.dot(residual) / by_disparity.squaredNorm();
      continue;
    }
    Eigen::Matrix3d cross;
    cross << 0.0, turned.z(), -turned.y(), -turned.z(), 0.0, turned.x(), turned.y(), -turned.x(), 0.0;
    by_all.setZero();
    by_all.block<1, 3>(0, 0) = Row(before.px.x()).transpose();
    by_all.block<1, 3>(3, 0) = Row(now.px.x()).transpose();
    by_all.block<3, 3>(1, 3) = by_p * cross;
    by_all.block<3, 3>(1, 6) = by_p * (d / fb);
    by_all = weights.asDiagonal() * by_all;
  }
  const double norm = by_disparity.squaredNorm();
  const double along = by_disparity.dot(residual);
  const double deviation = std::sqrt(std::max(0.0, residual.squaredNorm() - along * along / norm));
  if (!(deviation < max_deviation)) return false;
  const double weight = 1.0 / std::max(1.0, deviation / kHuber);
  const Eigen::Matrix<double, 9, 1> cross = by_all.transpose() * by_disparity;
  normal.leftCols<9>() += weight * (by_all.transpose() * by_all - cross * cross.transpose() / norm);
  normal.col(9) += weight * (by_all.transpose() * residual - cross * (along / norm));
  return true;
}

Eigen::Matrix3d DisparityCheck::Information(const Evidence& evidence) const {
  Eigen::Matrix3d information = evidence.information;
  information.diagonal() += DisparityErrorSigmas(kPriorSigma_px).cwiseAbs2().cwiseInverse();
  return information;
}

Eigen::Vector3d DisparityCheck::Solve(const Evidence& evidence) const {
  return SolveSymmetric<3>(Information(evidence), evidence.vector);
}

void DisparityCheck::Learn(SE3 T_now_before, std::vector<Seen> points) {
  Eigen::Vector3d b = Solve(all_);
  std::vector<double> disparities;
  for (Seen& point : points) {
    point.disparity_px = point.before.disparity_px - Row(point.before.px.x()).dot(b);
    disparities.push_back(point.disparity_px);
  }
  const double median_px = Median(disparities);
  for (int i = 0; i < kIterations; ++i) {
    Normal normal = Normal::Zero();
    const bool rejects = i >= kIterations - kRejectingIterations;
    const double max_deviation = rejects ? kMaxDeviation : std::numeric_limits<double>::infinity();
    for (Seen& point : points) Linearise(T_now_before, b, max_deviation, point, normal);
    Evidence all = all_;
    if (!AddWithoutMotion(normal, b, all)) return;
    const Eigen::Vector3d b_new = Solve(all);
    const Motion step = SolveSymmetric<6>(normal.block<6, 6>(3, 3),
                                          Motion(normal.block<6, 1>(3, 9) - normal.block<6, 3>(3, 0) * (b_new - b)));
    T_now_before = SE3(ExpSO3(step.head<3>()) * T_now_before.rotation(), T_now_before.translation() + step.tail<3>());
    b = b_new;
  }
  Normal all = Normal::Zero();
  Normal odd = Normal::Zero();
  Normal near = Normal::Zero();
  for (Seen& point : points) {
    Normal one = Normal::Zero();
    if (!Linearise(T_now_before, b, kMaxDeviation, point, one)) continue;
    all += one;
    if (point.before.landmark_id.value % 2 != 0) odd += one;
    if (point.disparity_px > median_px) near += one;
  }
  const auto add = [&b](const Normal& first, const Normal& second, Division& division) {
    AddWithoutMotion(first, b, division.first);
    AddWithoutMotion(second, b, division.second);
  };
  AddWithoutMotion(all, b, all_);
  AddWithoutMotion(all, b, n_stretches_ % 4 < 2 ? by_time_.first : by_time_.second);
  add(odd, all - odd, by_landmark_);
  add(near, all - near, by_depth_);
  ++n_stretches_;
  Decide();
}

// Root mean square at the centres of the thirds of the image.
double DisparityCheck::Size_px(const Eigen::Vector3d& coefficients) const {
  double square = 0.0;
  for (const double part : kThirds) square += std::pow(Row(part * camera_.width_px).dot(coefficients), 2);
  return std::sqrt(square / static_cast<double>(std::size(kThirds)));
}

double DisparityCheck::Sigma_px(const Eigen::Matrix3d& covariance) const {
  double variance = 0.0;
  for (const double part : kThirds) {
    const Eigen::Vector3d row = Row(part * camera_.width_px);
    variance += row.dot(covariance * row);
  }
  return std::sqrt(variance / static_cast<double>(std::size(kThirds)));
}

bool DisparityCheck::Differ(const Division& division, double share) const {
  const double half_px = Size_px(0.5 * (Solve(division.first) - Solve(division.second)));
  const Eigen::Matrix3d covariance =
      0.25 * (Information(division.first).inverse() + Information(division.second).inverse());
  return half_px > kDifferSigmas * Sigma_px(covariance) && half_px > share * Size_px(estimate_);
}

double DisparityCheck::MedianChange(const std::vector<Seen>& points) {
  std::vector<double> changes;
  changes.reserve(points.size());
  for (const Seen& point : points) {
    const double change = point.now.disparity_px / point.before.disparity_px;
    changes.push_back(std::max(change, 1.0 / change));
  }
  return changes.empty() ? 1.0 : Median(changes);
}

bool DisparityCheck::Confirms(const Eigen::Vector3d& coefficients_px, const Eigen::Matrix3d& covariance_px2) const {
  if (verdict_ != Verdict::kAgrees) return false;
  const Eigen::Matrix3d information = Information(all_);
  if (estimate_.dot(information * estimate_) < options_.min_chi_square) return false;
  const double half_px = Size_px(0.5 * (estimate_ - coefficients_px));
  const double sigma_px = Sigma_px(0.25 * (information.inverse() + covariance_px2));
  return half_px <= std::max(kDifferSigmas * sigma_px, kDifferShare * Size_px(coefficients_px));
}

void DisparityCheck::Decide() {
  estimate_ = Solve(all_);
  if (n_stretches_ < kMinStretches) return;
  const bool differ = Differ(by_landmark_, kDifferShare) || Differ(by_depth_, kDifferShare) ||
                      Differ(by_time_, kTimeFactor * kDifferShare);
  verdict_ = differ ? Verdict::kContradicts : Verdict::kAgrees;
}

}  // namespace plslam::vo
