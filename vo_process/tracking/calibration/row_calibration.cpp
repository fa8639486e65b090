// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/row_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "core/geometry/symmetric.h"
#include "core/motion/robust.h"

namespace plslam::vo {
namespace {

// Patches with a larger sigma of the row contribute little, and their errors are not Gaussian.
constexpr double kMaxSigmaRow_px = 0.4;
// Error that the residuals of a patch do not show: slant, interpolation, the position of the corner in a blurred image.
constexpr double kRowModelError_px = 0.2;
// Corners that are close together, or the same corner in several octaves, have common errors: a cell counts as one.
constexpr double kRowHuber = 1.5;

bool HasPreciseRow(const StereoPoint& p) {
  return p.HasDepth() && p.sigma_row_px >= 0.0 && p.sigma_row_px < kMaxSigmaRow_px;
}

}  // namespace

double RowHuberFactor(double deviation) { return std::max(1.0, deviation / kRowHuber); }

std::vector<RowObservation> RowObservationsOf(const StereoFeatures& features, const StereoCamera& camera) {
  std::vector<RowObservation> observations;
  std::array<int, kCellColumns * kCellRows> n_in_cell{};
  std::vector<size_t> cells;
  for (size_t i = 0; i < features.points.size(); ++i) {
    const StereoPoint& point = features.points[i];
    if (!HasPreciseRow(point)) continue;
    const Eigen::Vector2d place_px = point.left.px - Eigen::Vector2d(point.disparity_px, 0.0);
    cells.push_back(static_cast<size_t>(CellOf(place_px, camera)));
    ++n_in_cell[cells.back()];
    observations.push_back({i, place_px, point.row_offset_px,
                            point.sigma_row_px * point.sigma_row_px + kRowModelError_px * kRowModelError_px});
  }
  for (size_t i = 0; i < observations.size(); ++i) observations[i].sharing = n_in_cell[cells[i]];
  return observations;
}

namespace {

// Random walk from frame to frame: temperature, and model errors that change with the view.
constexpr double kRowDrift_px = 0.005;
// The same between runs.
constexpr double kBetweenRuns_px = 0.1;
// Least usable matches of a frame to update the filter, and to decide whether there is a vertical disparity.
constexpr size_t kEnoughToBegin = 20;
constexpr size_t kEnough = 50;
// Ratio of the median residuals with and without the field below which it is applied, and above which it is removed.
constexpr double kMaxResidualShare = 0.5;
constexpr double kMaxResidualShareOfUsed = 0.8;
constexpr double kMinShareOfUsed = 0.6;
// Medians are averaged over this number of frames, because slanted walls change them temporarily.
constexpr int64_t kMemory_frames = 40;

// Prior sigmas: of a pitch, of a common shift of all rows, and of other bending of the field.
constexpr double kPitchSigma_px = 5.0;
constexpr double kShiftSigma_px = 0.7;
constexpr double kBendSigma_px = 0.3;

template <class Value>
double MedianOf(const std::vector<RowObservation>& observations, const Value& value) {
  std::vector<double> values(observations.size());
  std::transform(observations.begin(), observations.end(), values.begin(), value);
  return Median(values);
}

}  // namespace

RowCalibration::RowCalibration(const StereoCamera& camera, const RowCalibrationOptions& options)
    : camera_(camera), options_(options) {
  covariance_.setIdentity();
  covariance_ *= options.prior_sigma_px * options.prior_sigma_px;
}

void RowCalibration::Begin(const SelfCalibration::Rows& learned) {
  if (!options_.enabled) return;
  state_ = learned.offsets_px;
  covariance_ = learned.covariance_px2;
  covariance_.diagonal().array() += kBetweenRuns_px * kBetweenRuns_px;
  used_ = has_learned_ = true;
  // Counts as one comparison that favoured the field.
  n_compared_ = 1;
  median_without_px_ = state_.norm();
}

bool RowCalibration::Observe(const StereoFeatures& features, const PairSkew& skew) {
  if (!options_.enabled) return false;
  ++n_frames_;
  std::vector<RowObservation> observations = RowObservationsOf(features, camera_);
  for (RowObservation& o : observations) {
    const StereoPoint& point = features.points[o.point];
    o.offset_px -= skew.RowOffsetAt_px(point.left.px, point.disparity_px);
  }
  if (observations.size() < kEnoughToBegin) return false;
  has_learned_ = has_learned_ || observations.size() >= kEnough;
  // Starts at the median: with several pixels of offset, correct matches would otherwise be rejected as outliers.
  if (n_compared_ == 0) state_(0) = MedianOf(observations, [](const RowObservation& o) { return o.offset_px; });
  covariance_.diagonal().array() += kRowDrift_px * kRowDrift_px;
  for (const RowObservation& observation : observations) Learn(observation);
  Compare(observations);
  const bool used_before = used_;
  used_ = IsSignificant();
  return used_ != used_before;
}

double RowCalibration::Innovation_px(const RowObservation& observation) const {
  return observation.offset_px - RowField::Terms(camera_, observation.place_px).dot(state_);
}

void RowCalibration::Learn(const RowObservation& observation) {
  const RowField::Coefficients terms = RowField::Terms(camera_, observation.place_px);
  const double innovation = Innovation_px(observation);
  const RowField::Coefficients gain = covariance_ * terms;
  const double deviation = std::abs(innovation) / std::sqrt(observation.variance_px2 + terms.dot(gain));
  if (!(deviation <= kMaxRowDeviation)) return;
  const double variance_px2 = observation.sharing * observation.variance_px2 * RowHuberFactor(deviation);
  const double total = variance_px2 + terms.dot(gain);
  state_ += innovation / total * gain;
  covariance_ -= gain * gain.transpose() / total;
}

void RowCalibration::Compare(const std::vector<RowObservation>& observations) {
  const double without_px = MedianOf(observations, [](const RowObservation& o) { return std::abs(o.offset_px); });
  const double with_px =
      MedianOf(observations, [this](const RowObservation& o) { return std::abs(Innovation_px(o)); });
  n_compared_ = std::min(n_compared_ + 1, kMemory_frames);
  const double share = 1.0 / static_cast<double>(n_compared_);
  median_without_px_ += share * (without_px - median_without_px_);
  median_with_px_ += share * (with_px - median_with_px_);
}

bool RowCalibration::IsSignificant() const {
  // An applied field is removed only if it is wrong, or small: each change disturbs the landmarks.
  if (used_) {
    return state_.norm() > kMinShareOfUsed * options_.min_offset_px &&
           median_with_px_ < kMaxResidualShareOfUsed * median_without_px_;
  }
  return state_.norm() > options_.min_offset_px && median_with_px_ < kMaxResidualShare * median_without_px_ &&
         SquaredMahalanobis<6>(state_, covariance_) > options_.min_chi_square;
}

// A pitch moves all rows, and those far from the middle more, by the square of their tangent; a common shift may have
// other causes (cropping, row numbering). Least squares over the pitch with the prior of each.
RowField::Turn RowCalibration::TurnShown() const {
  const double tangent = 0.5 * camera_.height_px / camera_.f_px;
  const double bend = tangent * tangent;
  const double bend_variance = kBendSigma_px * kBendSigma_px + covariance_(5, 5);
  const double shift_variance = kShiftSigma_px * kShiftSigma_px + covariance_(0, 0);
  const double information =
      1.0 / (kPitchSigma_px * kPitchSigma_px) + 1.0 / shift_variance + bend * bend / bend_variance;
  const double pitch_px = (state_(0) / shift_variance + bend * state_(5) / bend_variance) / information;
  return {pitch_px / camera_.f_px, 2.0 * state_(1) / camera_.width_px};
}

}  // namespace plslam::vo
