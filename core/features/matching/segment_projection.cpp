// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/matching/segment_projection.h"

#include <algorithm>
#include <cmath>

namespace plslam {
namespace {

// sin^2 of the least angle between a viewing ray and a line for which the nearest position is meaningful.
constexpr double kMinSine2 = 1e-4;
constexpr double kMinLength_px = 5.0;

}  // namespace

std::optional<Segment3> ClipInFront(const Segment3& segment_c, double min_depth_m) {
  Segment3 clipped = segment_c;
  if (clipped.p.z() < min_depth_m && clipped.q.z() < min_depth_m) return std::nullopt;
  const Eigen::Vector3d along = clipped.q - clipped.p;
  if (clipped.p.z() < min_depth_m) clipped.p += (min_depth_m - clipped.p.z()) / along.z() * along;
  if (clipped.q.z() < min_depth_m) clipped.q += (min_depth_m - clipped.q.z()) / along.z() * along;
  return clipped;
}

std::optional<Segment2> ClipToImage(const Segment2& segment, const StereoCamera& camera, double margin_px) {
  // Liang-Barsky against the image extended by the margin.
  const Eigen::Vector2d low(camera.left_px - margin_px, camera.top_px - margin_px);
  const Eigen::Vector2d high(camera.left_px + camera.width_px - 1 + margin_px,
                             camera.top_px + camera.height_px - 1 + margin_px);
  const Eigen::Vector2d along = segment.q - segment.p;
  double from = 0.0;
  double to = 1.0;
  for (int k = 0; k < 2; ++k) {
    if (std::abs(along[k]) < 1e-9) {
      if (segment.p[k] < low[k] || segment.p[k] > high[k]) return std::nullopt;
      continue;
    }
    const double a = (low[k] - segment.p[k]) / along[k];
    const double b = (high[k] - segment.p[k]) / along[k];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  if (!((to - from) * along.norm() >= kMinLength_px)) return std::nullopt;
  // Clamped, because rounding could put an end outside again.
  const auto at = [&](double s) -> Eigen::Vector2d { return (segment.p + s * along).cwiseMax(low).cwiseMin(high); };
  return Segment2{from > 0.0 ? at(from) : segment.p, to < 1.0 ? at(to) : segment.q};
}

std::optional<Segment2> ProjectSegment(const Segment3& segment_c, const StereoCamera& camera, double margin_px) {
  const auto visible = ClipInFront(segment_c, camera.MinDepth());
  if (!visible) return std::nullopt;
  return ClipToImage({camera.Project(visible->p), camera.Project(visible->q)}, camera, margin_px);
}

double VarianceAcross(const Segment2& observed, const Eigen::Vector2d& px, double sigma_px) {
  const double length = observed.Length();
  const double along = (px - observed.p).dot(observed.q - observed.p) / length;
  const double beyond = std::max({0.0, -along, along - length});
  const double sigma = sigma_px * (1.0 + 2.0 * beyond / length);
  return sigma * sigma;
}

Segment2 RightSegment(const StereoLine& seen) {
  return {seen.left.segment.p - Eigen::Vector2d(seen.disparity_p_px, 0.0),
          seen.left.segment.q - Eigen::Vector2d(seen.disparity_q_px, 0.0)};
}

std::optional<double> AlongLine(const Segment3& segment_c, const Eigen::Vector2d& px, const StereoCamera& camera) {
  const Eigen::Vector3d ray = Eigen::Vector3d(px.x() - camera.cx_px, px.y() - camera.cy_px, camera.f_px).normalized();
  const Eigen::Vector3d along = segment_c.q - segment_c.p;
  // Least squares of |p + s along - t ray|, with t eliminated.
  const Eigen::Vector3d across = along - ray.dot(along) * ray;
  const double square = across.squaredNorm();
  if (square < kMinSine2 * along.squaredNorm()) return std::nullopt;
  return -across.dot(segment_c.p) / square;
}

}  // namespace plslam
