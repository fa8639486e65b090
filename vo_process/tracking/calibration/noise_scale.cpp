// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/noise_scale.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/hypot.h"

namespace plslam::vo {
namespace {

constexpr size_t kMinOfEach = 20;
// Ratio of residuals of points and lines that is normal: medians of a hundred lines differ as much.
constexpr double kAllowedRatio = 1.1;
// Common errors of points move the pose, and do not show in their residuals, so sigmas grow by more than the residuals
// show.
constexpr double kCommonPower = 1.5;
// Step towards the new factor in one frame, in logarithms.
constexpr double kGain = 0.2;
// The same towards 1 for frames with too few of one feature type: the factor may not apply to them.
constexpr double kForgottenShare = 0.05;

}  // namespace

void NoiseScale::Apply(StereoFeatures& features) const {
  for (StereoPoint& point : features.points) {
    point.sigma_px *= scale_;
    point.sigma_disparity_px *= scale_;
  }
}

void NoiseScale::Observe(const Alignment& alignment) {
  if (alignment.matches.points.size() < kMinOfEach || alignment.matches.lines.size() < kMinOfEach) {
    scale_ = std::pow(scale_, 1.0 - kForgottenShare);
    return;
  }
  // Ratio with the original sigmas of the points.
  const double ratio = scale_ * alignment.point_deviation / (kAllowedRatio * alignment.line_deviation);
  if (!(ratio > 0.0) || !std::isfinite(ratio)) return;
  const double wanted = std::pow(ratio, kCommonPower);
  scale_ = std::clamp(scale_ * std::pow(wanted / scale_, kGain), 1.0, max_scale_);
}

namespace {

// Flatter segments have no depth.
constexpr double kMinSine = 0.1;

}  // namespace

void AddLineModelError(double sigma_px, StereoFeatures& features) {
  for (StereoLine& line : features.lines) {
    line.sigma_px = Hypot(line.sigma_px, sigma_px);
    const Segment2& segment = line.left.segment;
    const double sine = std::max(std::abs(segment.q.y() - segment.p.y()) / segment.Length(), kMinSine);
    // Along the row the errors of both images count, each divided by the sine of the angle to the row.
    const double disparity_sigma_px = M_SQRT2 * sigma_px / sine;
    line.sigma_disparity_p_px = Hypot(line.sigma_disparity_p_px, disparity_sigma_px);
    line.sigma_disparity_q_px = Hypot(line.sigma_disparity_q_px, disparity_sigma_px);
  }
}

}  // namespace plslam::vo
