#include "core/features/line_sigma.h"

#include <algorithm>
#include <cmath>

namespace plslam {
namespace {

/// Deviation of one edge place times its contrast: image noise of about 2 grey levels, and the correlation of
/// neighbours through the gradient filter.
constexpr double kNoise = 3.0;
constexpr double kFloor_px = 0.03;

}  // namespace

double LineSigma_px(double length_px, double contrast, double t) {
  const double place = kNoise / std::max(contrast, 1.0);
  const double n = std::max(length_px, 1.0);
  return std::sqrt((place * place / n + kFloor_px * kFloor_px / 4.0) * (1.0 + 3.0 * t * t));
}

double PlaceAlong(const Segment2& segment, const Eigen::Vector2d& point) {
  const Eigen::Vector2d step = segment.q - segment.p;
  const double squared = step.squaredNorm();
  return squared > 0.0 ? 2.0 * step.dot(point - segment.p) / squared - 1.0 : 0.0;
}

}  // namespace plslam
