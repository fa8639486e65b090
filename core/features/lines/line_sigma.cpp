// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/line_sigma.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/hypot.h"

namespace plslam {
namespace {

constexpr int kReach = kMaxEdgeWidth_px / 2;
constexpr int kPlaces = 8;

/// Sums of the gradient across, from the darker to the brighter side.
std::array<double, kMaxEdgeWidth_px> ProfileAcross(const Gradients& gradients, const Segment2& segment,
                                                   double length) {
  const Eigen::Vector2d step = segment.q - segment.p;
  const Eigen::Vector2d normal(-step.y() / length, step.x() / length);
  const double right = gradients.dx.cols - 1;
  const double bottom = gradients.dx.rows - 1;
  std::array<double, kMaxEdgeWidth_px> profile{};
  for (int k = 0; k < kPlaces; ++k) {
    Eigen::Vector2d at = segment.p + (k + 0.5) / kPlaces * step - kReach * normal;
    for (double& sum : profile) {
      const int x = static_cast<int>(std::lround(std::clamp(at.x(), 0.0, right)));
      const int y = static_cast<int>(std::lround(std::clamp(at.y(), 0.0, bottom)));
      sum += normal.x() * gradients.dx.at<int16_t>(y, x) + normal.y() * gradients.dy.at<int16_t>(y, x);
      at += normal;
    }
  }
  return profile;
}

}  // namespace

int EdgeWidth_px(const Gradients& gradients, const Segment2& segment) {
  const double length = segment.Length();
  if (!(length > 0.0)) return 0;
  const std::array<double, kMaxEdgeWidth_px> profile = ProfileAcross(gradients, segment, length);
  const auto at = [&profile](int offset) { return profile[static_cast<size_t>(kReach + offset)]; };
  const double half = 0.5 * std::max({at(-1), at(0), at(1)});
  int first = 0;
  int last = 0;
  while (first > -kReach && at(first - 1) >= half) --first;
  while (last < kReach && at(last + 1) >= half) ++last;
  return last - first + 1;
}

namespace {

/// Sigma of one edge position times its contrast: image noise of about 2 grey levels, and the correlation of
/// neighbours by the gradient filter.
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
  return line.octave == 0 ? fit : Hypot(fit, kBlurred_px * (1 << line.octave));
}

double PlaceAlong(const Segment2& segment, const Eigen::Vector2d& point) {
  const Eigen::Vector2d step = segment.q - segment.p;
  const double squared = step.squaredNorm();
  return squared > 0.0 ? 2.0 * step.dot(point - segment.p) / squared - 1.0 : 0.0;
}

}  // namespace plslam
