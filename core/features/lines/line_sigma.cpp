// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/line_sigma.h"

#include <algorithm>
#include <cmath>

namespace plslam {
namespace {

/// Deviation of one edge place times its contrast: image noise of about 2 grey levels, and the correlation of
/// neighbours through the gradient filter.
constexpr double kNoise = 3.0;
constexpr double kFloor_px = 0.03;
/// In pixels of the line's own image.
constexpr double kBlurred_px = 0.1;

}  // namespace

double LineSigma_px(double length_px, double contrast, double t, int octave) {
  const double scale = 1 << octave;
  const double place = kNoise / (scale * std::max(contrast, 1.0));
  const double n = std::max(length_px / scale, 1.0);
  return scale * std::sqrt((place * place / n + kFloor_px * kFloor_px / 4.0) * (1.0 + 3.0 * t * t));
}

double EndSigma_px(const LineFeature& line) {
  const double fit = LineSigma_px(line.segment.Length(), line.response, 1.0, line.octave);
  return line.octave == 0 ? fit : std::hypot(fit, kBlurred_px * (1 << line.octave));
}

double PlaceAlong(const Segment2& segment, const Eigen::Vector2d& point) {
  const Eigen::Vector2d step = segment.q - segment.p;
  const double squared = step.squaredNorm();
  return squared > 0.0 ? 2.0 * step.dot(point - segment.p) / squared - 1.0 : 0.0;
}

}  // namespace plslam
