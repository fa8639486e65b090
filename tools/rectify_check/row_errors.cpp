// SPDX-License-Identifier: BSD-3-Clause
#include "tools/rectify_check/row_errors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "core/features/matching/descriptor_matcher.h"

namespace plslam::rectify_check {
namespace {

constexpr int kMinMatches = 30;
/// Limits derived from stereo matching (core/features/options.h, StereoOptions): a standard deviation of 0.3 px, 2 px
/// at most.
constexpr double kGood_px = 0.5;
constexpr double kUsable_px = 1.0;

/// Returns the quantile: the value above the given share of the others. Precondition: not empty.
double Quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Least squares of offset, roll and scale, with little weight for outliers (Cauchy weights with the scale of the
/// median deviation, not below a fifth of a pixel).
Eigen::Vector3d FitRows(const std::vector<RowMatch>& matches, const StereoCamera& camera) {
  Eigen::Vector3d fit = Eigen::Vector3d::Zero();
  std::vector<double> errors;
  errors.reserve(matches.size());
  std::vector<Eigen::Vector3d> rows;
  rows.reserve(matches.size());
  for (const RowMatch& m : matches) {
    errors.push_back(m.RowError());
    const Eigen::Vector2d xy = (m.left_px - Eigen::Vector2d(camera.cx_px, camera.cy_px)) / camera.f_px;
    rows.emplace_back(1.0, xy.x(), xy.y());
  }
  fit[0] = Quantile(errors, 0.5);
  for (int iteration = 0; iteration < 20; ++iteration) {
    std::vector<double> residuals, sizes;
    for (size_t i = 0; i < rows.size(); ++i) {
      residuals.push_back(errors[i] - rows[i].dot(fit));
      sizes.push_back(std::abs(residuals.back()));
    }
    const double scale = std::max(0.2, 1.48 * Quantile(sizes, 0.5));
    Eigen::Matrix3d H = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < rows.size(); ++i) {
      const double weight = 1.0 / (1.0 + std::pow(residuals[i] / scale, 2));
      H += weight * rows[i] * rows[i].transpose();
      g += weight * rows[i] * residuals[i];
    }
    fit += H.ldlt().solve(g);
  }
  return fit;
}

/// The largest of the three causes, in words.
std::string Cause(const RowErrors& e) {
  // Each as it shows at the border of a common view, 0.6 focal lengths from the centre.
  const double border_px = 0.6 * e.f_px;
  const double offset_px = std::abs(e.offset_px);
  const double roll_px = border_px * std::abs(e.roll_deg) * std::numbers::pi / 180.0;
  const double scale_px = border_px * std::abs(e.scale_percent) / 100.0;
  if (offset_px >= std::max(roll_px, scale_px)) {
    return fmt::format("the right image is {:+.1f} px lower (pitch between the cameras, or principal points)",
                       e.offset_px);
  }
  return roll_px >= scale_px
             ? fmt::format("the right camera is rolled by {:+.2f} deg", e.roll_deg)
             : fmt::format("the right image is {:+.2f} % larger (focal lengths, or distortion)", e.scale_percent);
}

}  // namespace

std::vector<RowMatch> MatchAcrossRows(const ImageFeatures& left, const ImageFeatures& right, int height_px) {
  MatchOptions options;
  options.ratio = 0.8;
  const std::vector<int> match_of = MatchPointsBruteForce(left.points, right.points, options);
  std::vector<RowMatch> matches;
  for (size_t i = 0; i < match_of.size(); ++i) {
    if (match_of[i] < 0) continue;
    const RowMatch match{left.points[i].px, right.points[match_of[i]].px};
    if (std::abs(match.RowError()) <= 0.1 * height_px) matches.push_back(match);
  }
  return matches;
}

RowErrors MeasureRows(const std::vector<RowMatch>& matches, const StereoCamera& camera) {
  RowErrors result;
  result.matches = static_cast<int>(matches.size());
  if (matches.size() < 3) return result;
  std::vector<double> errors, sizes;
  int behind = 0;
  for (const RowMatch& match : matches) {
    errors.push_back(match.RowError());
    sizes.push_back(std::abs(match.RowError()));
    behind += match.Disparity() < 0.0 ? 1 : 0;
  }
  result.median_px = Quantile(errors, 0.5);
  result.median_abs_px = Quantile(sizes, 0.5);
  result.p95_abs_px = Quantile(sizes, 0.95);
  result.behind = static_cast<double>(behind) / static_cast<double>(matches.size());
  const Eigen::Vector3d fit = FitRows(matches, camera);
  result.f_px = camera.f_px;
  result.offset_px = fit[0];
  result.roll_deg = fit[1] / camera.f_px * 180.0 / std::numbers::pi;
  result.scale_percent = 100.0 * fit[2] / camera.f_px;
  return result;
}

RowVerdict CheckRows(const RowErrors& e) {
  if (e.matches < kMinMatches) {
    return {false, fmt::format("only {} points were found in both images, too few to judge: the scene has no "
                               "texture, the images are not a pair, or the calibration is far off",
                               e.matches)};
  }
  if (e.behind > 0.5) {
    return {false, fmt::format("{:.0f} % of the points would lie behind the camera: left and right are exchanged",
                               100.0 * e.behind)};
  }
  if (e.median_abs_px > kUsable_px) {
    return {false, fmt::format("rows disagree by {:.2f} px: {}; calibrate again", e.median_abs_px, Cause(e))};
  }
  if (e.median_abs_px > kGood_px) {
    return {true,
            fmt::format("rows agree to {:.2f} px, which works but loses matches: {}", e.median_abs_px, Cause(e))};
  }
  return {true, fmt::format("rows agree to {:.2f} px, which is good", e.median_abs_px)};
}

}  // namespace plslam::rectify_check
