// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/segment_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/features/image/gradients.h"

namespace plslam::vo {
namespace {

constexpr int kReach = kSegmentReach_px;
// Gradients on both sides of the positions at which a peak may be, and the Sobel filter beyond these.
constexpr int kGradients = 2 * (kReach + 1) + 1;
constexpr int kColumns = kGradients + 4;
constexpr int kMinPositions = 8;
constexpr double kMinShare = 0.6;
constexpr double kMaxContrastRatio = 2.0;
constexpr double kFirstLimit_px = 1.0;
constexpr double kLeastLimit_px = 0.3;
constexpr double kMaxRms_px = 0.6;

/// An edge position: step along the major axis of the segment, and place along the minor one.
struct Position {
  double major = 0.0;
  double place = 0.0;
  double strength = 0.0;
};

/// Weighted line place = a + b * major.
struct Fit {
  double n = 0, m = 0, p = 0, mm = 0, mp = 0;
  double a = 0, b = 0;

  void Add(const Position& at, double weight) {
    n += weight;
    m += weight * at.major;
    p += weight * at.place;
    mm += weight * at.major * at.major;
    mp += weight * at.major * at.place;
  }
  bool Solve() {
    const double determinant = n * mm - m * m;
    if (!(determinant > 0.0)) return false;
    b = (n * mp - m * p) / determinant;
    a = (p - b * m) / n;
    return true;
  }
  double Residual(const Position& at) const { return at.place - a - b * at.major; }
};

/// Locates the edge in one step: `pixels` points at (major, first minor) - the pixel of the first column; the strides
/// step along both axes.
std::optional<Position> LocateEdge(const uint8_t* pixels, ptrdiff_t major_stride, ptrdiff_t minor_stride, int major,
                                   int first, double expected, double sign) {
  std::array<int, kColumns> smooth;
  for (int i = 0; i < kColumns; ++i) {
    const uint8_t* p = pixels + i * minor_stride;
    smooth[static_cast<size_t>(i)] =
        p[-2 * major_stride] + p[2 * major_stride] + 4 * (p[-major_stride] + p[major_stride]) + 6 * p[0];
  }
  std::array<double, kGradients> gradient;
  for (size_t i = 0; i < kGradients; ++i) {
    gradient[i] = sign * (smooth[i + 4] - smooth[i] + 2 * (smooth[i + 3] - smooth[i + 1]));
  }
  std::optional<Position> best;
  double nearest = kReach + 0.5;
  for (size_t i = 1; i + 1 < kGradients; ++i) {
    const double before = gradient[i - 1], middle = gradient[i], after = gradient[i + 1];
    if (!(middle > 0.0 && middle > before && middle >= after)) continue;
    const double curvature = before - 2.0 * middle + after;
    const double shift = curvature < 0.0 ? std::clamp(0.5 * (before - after) / curvature, -1.0, 1.0) : 0.0;
    const double place = first + 2.0 + static_cast<double>(i) + shift;
    if (std::abs(place - expected) >= nearest) continue;
    nearest = std::abs(place - expected);
    best = Position{static_cast<double>(major), place, middle};
  }
  return best;
}

}  // namespace

std::optional<LineFeature> LocateSegment(const cv::Mat& image, const LineFeature& line, const Segment2& expected) {
  const double size_px = std::pow(2.0, line.octave);
  const Eigen::Vector2d p = expected.p / size_px;
  const Eigen::Vector2d q = expected.q / size_px;
  const Eigen::Vector2d along = q - p;
  const bool steep = std::abs(along.y()) >= std::abs(along.x());
  const int axis = steep ? 1 : 0;
  const int other = 1 - axis;
  if (!(std::abs(along[axis]) > kMinPositions)) return std::nullopt;
  // Brighter on the right of p->q: downwards has the left side of the image on its right, rightwards the lower side.
  const double sign = steep ? (along.y() > 0.0 ? -1.0 : 1.0) : (along.x() > 0.0 ? 1.0 : -1.0);
  const ptrdiff_t row_stride = static_cast<ptrdiff_t>(image.step);
  const ptrdiff_t major_stride = steep ? row_stride : 1;
  const ptrdiff_t minor_stride = steep ? 1 : row_stride;
  const int major_size = steep ? image.rows : image.cols;
  const int minor_size = steep ? image.cols : image.rows;
  const int begin = static_cast<int>(std::ceil(std::min(p[axis], q[axis])));
  const int end = static_cast<int>(std::floor(std::max(p[axis], q[axis])));
  const double slope = along[other] / along[axis];
  std::vector<Position> positions;
  for (int major = std::max(begin, 2); major <= std::min(end, major_size - 3); ++major) {
    const double place = p[other] + slope * (major - p[axis]);
    const int first = static_cast<int>(std::lround(place)) - kReach - 3;
    if (first < 0 || first + kColumns > minor_size) continue;
    const uint8_t* pixels = image.data + major * major_stride + first * minor_stride;
    if (const auto at = LocateEdge(pixels, major_stride, minor_stride, major, first, place, sign))
      positions.push_back(*at);
  }
  // All positions first, then without those of neighbouring edges.
  Fit fit;
  for (const Position& at : positions) fit.Add(at, 1.0);
  if (!fit.Solve()) return std::nullopt;
  double limit = kFirstLimit_px;
  int n = 0;
  double strength = 0.0;
  double first_major = 0.0, last_major = 0.0;
  for (int round = 0; round < 3; ++round) {
    Fit next;
    double squares = 0.0, weights = 0.0;
    n = 0;
    strength = 0.0;
    for (const Position& at : positions) {
      const double r = fit.Residual(at);
      if (std::abs(r) > limit) continue;
      next.Add(at, at.strength);
      squares += at.strength * r * r;
      weights += at.strength;
      strength += at.strength;
      if (n == 0) first_major = at.major;
      last_major = at.major;
      ++n;
    }
    if (n < kMinPositions || !next.Solve()) return std::nullopt;
    fit = next;
    const double rms = std::sqrt(squares / weights);
    if (round > 0 && rms > kMaxRms_px) return std::nullopt;
    limit = std::max(kLeastLimit_px, 2.5 * rms);
  }
  if (n < kMinShare * (end - begin + 1)) return std::nullopt;
  LineFeature found = line;
  const double contrast = strength / n * std::sqrt(1.0 + fit.b * fit.b) / Gradients::kStepGain;
  if (contrast * kMaxContrastRatio < line.response || contrast > kMaxContrastRatio * line.response)
    return std::nullopt;
  found.response = static_cast<float>(contrast);
  for (Eigen::Vector2d* end_px : {&found.segment.p, &found.segment.q}) {
    const double at = end_px == &found.segment.p ? p[axis] : q[axis];
    Eigen::Vector2d on_line;
    on_line[axis] = std::clamp(at, first_major - 0.5, last_major + 0.5);
    on_line[other] = fit.a + fit.b * on_line[axis];
    *end_px = on_line * size_px;
  }
  return found;
}

}  // namespace plslam::vo
