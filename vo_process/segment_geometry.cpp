#include "vo_process/segment_geometry.h"

#include <algorithm>

namespace plslam {
namespace {

// sin^2 of the least angle between a viewing ray and a line for which the nearest place is meaningful.
constexpr double kMinSine2 = 1e-4;

}  // namespace

std::optional<Segment3> ClipInFront(const Segment3& segment_c, double min_depth_m) {
  Segment3 clipped = segment_c;
  if (clipped.p.z() < min_depth_m && clipped.q.z() < min_depth_m) return std::nullopt;
  const Eigen::Vector3d along = clipped.q - clipped.p;
  if (clipped.p.z() < min_depth_m) clipped.p += (min_depth_m - clipped.p.z()) / along.z() * along;
  if (clipped.q.z() < min_depth_m) clipped.q += (min_depth_m - clipped.q.z()) / along.z() * along;
  return clipped;
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
