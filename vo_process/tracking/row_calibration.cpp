#include "vo_process/tracking/row_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "core/motion/robust.h"

namespace plslam {
namespace {

// Patches that tell the row less well have little to say, and their errors are not of the normal kind.
constexpr double kMaxSigmaRow_px = 0.4;
// What the residuals of a patch do not show: slant, interpolation, the place of the corner in an image that is not sharp.
constexpr double kRowModelError_px = 0.2;
// Corners that lie together, or are the same one in several octaves, err together: a cell of the image has one voice.
constexpr int kCellsAlong = 8;
constexpr int kCellsDown = 6;
constexpr double kMaxRowDeviation = 4.0;
constexpr double kRowHuber = 1.5;
// Change from frame to frame: of warmth, and of what the model leaves out as the view changes.
constexpr double kRowDrift_px = 0.005;
// Matches of a frame that tell something, and that tell whether rows differ.
constexpr size_t kEnoughToBegin = 20;
constexpr size_t kEnough = 50;
// Where rows do differ, most matches are off by less with the field than without it: by this factor to begin with it, and
// by this to go on.
constexpr double kMaxResidualShare = 0.5;
constexpr double kMaxResidualShareOfUsed = 0.8;
constexpr double kMinShareOfUsed = 0.6;
// Medians are means over so many frames: rigs do not bend in a second, but walls at an angle come and go.
constexpr int64_t kMemory_frames = 40;

// What is expected: of a pitch, of rows that are all shifted alike, and of what else bends the field.
constexpr double kPitchSigma_px = 5.0;
constexpr double kShiftSigma_px = 0.7;
constexpr double kBendSigma_px = 0.3;

bool TellsItsRow(const StereoPoint& p) {
  return p.HasDepth() && p.sigma_row_px >= 0.0 && p.sigma_row_px < kMaxSigmaRow_px;
}

template <class Sights, class Value>
double MedianOf(const Sights& sights, const Value& value) {
  std::vector<double> values(sights.size());
  std::transform(sights.begin(), sights.end(), values.begin(), value);
  return Median(values);
}

}  // namespace

RowCalibration::RowCalibration(const StereoCamera& camera, const RowCalibrationOptions& options)
    : camera_(camera), options_(options) {
  covariance_.setIdentity();
  covariance_ *= options.prior_sigma_px * options.prior_sigma_px;
}

bool RowCalibration::Observe(const StereoFeatures& features) {
  if (!options_.enabled) return false;
  ++n_frames_;
  const std::vector<RowSight> sights = SightsOf(features);
  if (sights.size() < kEnoughToBegin) return false;
  has_learned_ = has_learned_ || sights.size() >= kEnough;
  // Several pixels, and what agrees would seem to be wrong: so what most agree on comes first.
  if (n_compared_ == 0) state_(0) = MedianOf(sights, [](const RowSight& s) { return s.offset_px; });
  covariance_.diagonal().array() += kRowDrift_px * kRowDrift_px;
  for (const RowSight& sight : sights) Learn(sight);
  Compare(sights);
  const bool used_before = used_;
  used_ = IsWorthIt();
  return used_ != used_before;
}

std::vector<RowCalibration::RowSight> RowCalibration::SightsOf(const StereoFeatures& features) const {
  std::vector<RowSight> sights;
  std::array<int, kCellsAlong * kCellsDown> n_in_cell{};
  std::vector<size_t> cells;
  for (const StereoPoint& point : features.points) {
    if (!TellsItsRow(point)) continue;
    const Eigen::Vector2d place_px = point.left.px - Eigen::Vector2d(point.disparity_px, 0.0);
    const auto along =
        std::clamp(static_cast<int>(kCellsAlong * place_px.x() / camera_.width_px), 0, kCellsAlong - 1);
    const auto down = std::clamp(static_cast<int>(kCellsDown * place_px.y() / camera_.height_px), 0, kCellsDown - 1);
    cells.push_back(static_cast<size_t>(down * kCellsAlong + along));
    ++n_in_cell[cells.back()];
    sights.push_back({RowField::Terms(camera_, place_px), point.row_offset_px,
                      point.sigma_row_px * point.sigma_row_px + kRowModelError_px * kRowModelError_px});
  }
  for (size_t i = 0; i < sights.size(); ++i) sights[i].sharing = n_in_cell[cells[i]];
  return sights;
}

void RowCalibration::Learn(const RowSight& sight) {
  const double innovation = sight.offset_px - sight.terms.dot(state_);
  const RowField::Coefficients gain = covariance_ * sight.terms;
  const double deviation = std::abs(innovation) / std::sqrt(sight.variance_px2 + sight.terms.dot(gain));
  if (!(deviation <= kMaxRowDeviation)) return;
  const double variance_px2 = sight.sharing * sight.variance_px2 * std::max(1.0, deviation / kRowHuber);
  const double total = variance_px2 + sight.terms.dot(gain);
  state_ += innovation / total * gain;
  covariance_ -= gain * gain.transpose() / total;
}

void RowCalibration::Compare(const std::vector<RowSight>& sights) {
  const double without_px = MedianOf(sights, [](const RowSight& s) { return std::abs(s.offset_px); });
  const double with_px =
      MedianOf(sights, [this](const RowSight& s) { return std::abs(s.offset_px - s.terms.dot(state_)); });
  n_compared_ = std::min(n_compared_ + 1, kMemory_frames);
  const double share = 1.0 / static_cast<double>(n_compared_);
  median_without_px_ += share * (without_px - median_without_px_);
  median_with_px_ += share * (with_px - median_with_px_);
}

bool RowCalibration::IsWorthIt() const {
  // Once used, it is left only where it shows to be wrong, or small: each change disturbs the landmarks.
  if (used_) {
    return state_.norm() > kMinShareOfUsed * options_.min_offset_px &&
           median_with_px_ < kMaxResidualShareOfUsed * median_without_px_;
  }
  return state_.norm() > options_.min_offset_px && median_with_px_ < kMaxResidualShare * median_without_px_ &&
         state_.dot(covariance_.ldlt().solve(state_)) > options_.min_chi_square;
}

// A pitch moves all rows, and those far from the middle more, by the square of their tangent; rows that are all lower by the same
// may also be cut or counted otherwise. Least squares over the pitch with what is expected of each as a prior.
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

}  // namespace plslam
