#include "vo_process/kind_balance.h"

#include <algorithm>
#include <cmath>

namespace plslam {
namespace {

constexpr size_t kMinOfEach = 20;
// Where the residuals of points are larger by less than this, nothing is wrong: medians of a hundred lines differ as much.
constexpr double kAllowedRatio = 1.1;
// Share of the way, in logarithms, that one frame goes.
constexpr double kGain = 0.1;

}  // namespace

void KindBalance::Apply(StereoFeatures& features) const {
  for (StereoPoint& point : features.points) {
    point.sigma_px *= scale_;
    point.sigma_disparity_px *= scale_;
  }
}

void KindBalance::Observe(const Alignment& alignment) {
  if (alignment.matches.points.size() < kMinOfEach || alignment.matches.lines.size() < kMinOfEach) return;
  const double ratio = alignment.point_deviation / (kAllowedRatio * alignment.line_deviation);
  if (!(ratio > 0.0) || !std::isfinite(ratio)) return;
  scale_ = std::clamp(scale_ * std::pow(ratio, kGain), 1.0, max_scale_);
}

}  // namespace plslam
