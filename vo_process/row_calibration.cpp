#include "vo_process/row_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
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
constexpr size_t kEnoughToBegin = 20;
// Where rows do differ, most matches are off by less with the field than without it: by this factor to begin with it, and
// by this to go on.
constexpr double kMaxResidualShare = 0.5;
constexpr double kMaxResidualShareOfUsed = 0.8;
// Medians are means over so many frames: rigs do not bend in a second, but walls at an angle come and go.
constexpr int64_t kMemory_frames = 40;

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
  if (!features.points.empty()) ++n_frames_;
  const std::vector<RowSight> sights = SightsOf(features);
  // Several pixels, and what agrees would seem to be wrong: so what most agree on comes first.
  if (!has_learned() && sights.size() >= kEnoughToBegin)
    state_(0) = MedianOf(sights, [](const RowSight& s) { return s.offset_px; });
  n_learned_ += static_cast<int64_t>(sights.size());
  covariance_.diagonal().array() += kRowDrift_px * kRowDrift_px;
  for (const RowSight& sight : sights) Learn(sight);
  if (sights.size() >= kEnoughToBegin) Compare(sights);
  const bool used_before = used_;
  used_ = IsWorthIt();
  return used_ && !used_before;
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
  const double max_share = used_ ? kMaxResidualShareOfUsed : kMaxResidualShare;
  return state_.norm() > options_.min_offset_px && median_with_px_ < max_share * median_without_px_ &&
         state_.dot(covariance_.ldlt().solve(state_)) > options_.min_chi_square;
}

}  // namespace plslam
