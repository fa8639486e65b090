#include "mapping_process/insertion/sight_error.h"

#include <algorithm>
#include <cmath>

#include "core/features/matching/segment_projection.h"
#include "core/motion/residual.h"

namespace plslam {
namespace {

double Capped(double error) { return error < kMostSightError ? error : kMostSightError; }

// Squared distance across the observed line of one image, in standard deviations.
double Across(const Segment2& observed, const Eigen::Vector2d& px, double sigma_px) {
  const double distance_px = LineThrough(observed).dot(px.homogeneous());
  return distance_px * distance_px / VarianceAcross(observed, px, sigma_px);
}

constexpr double kNear_px = 40.0;

}  // namespace

bool IsNear(const MapPoint& point, const StereoPoint& seen, const SE3& T_kf_w, const StereoCamera& camera) {
  if (IsBehind(point, T_kf_w, camera)) return false;
  return (camera.Project(T_kf_w * point.p_w) - seen.left.px).norm() < kNear_px;
}

bool IsNear(const MapLine& line, const StereoLine& seen, const SE3& T_kf_w, const StereoCamera& camera) {
  const auto segment = ClipInFront({T_kf_w * line.segment_w.p, T_kf_w * line.segment_w.q}, camera.MinDepth());
  if (!segment || !(seen.left.segment.Length() > 0.0)) return false;
  const Eigen::Vector2d middle = 0.5 * (seen.left.segment.p + seen.left.segment.q);
  const Segment2 projected{camera.Project(segment->p), camera.Project(segment->q)};
  return projected.Length() > 0.0 && std::abs(LineThrough(projected).dot(middle.homogeneous())) < kNear_px;
}

bool IsBehind(const MapPoint& point, const SE3& T_kf_w, const StereoCamera& camera) {
  return !((T_kf_w * point.p_w).z() > camera.MinDepth());
}

bool IsBehind(const MapLine& line, const SE3& T_kf_w, const StereoCamera& camera) {
  const double least_m = camera.MinDepth();
  return !((T_kf_w * line.segment_w.p).z() > least_m) && !((T_kf_w * line.segment_w.q).z() > least_m);
}

double SightError(const MapPoint& point, const StereoPoint& seen, const SE3& T_kf_w, const StereoCamera& camera) {
  if (IsBehind(point, T_kf_w, camera)) return kMostSightError;
  const Eigen::Vector3d uvd = camera.ProjectStereo(T_kf_w * point.p_w);
  double error = (uvd.head<2>() - seen.left.px).squaredNorm() / (seen.sigma_px * seen.sigma_px);
  if (seen.HasDepth()) error += std::pow((uvd.z() - seen.disparity_px) / seen.sigma_disparity_px, 2);
  return Capped(error);
}

double SightError(const MapLine& line, const StereoLine& seen, const SE3& T_kf_w, const StereoCamera& camera) {
  double error = 0.0;
  for (const Eigen::Vector3d& end_w : {line.segment_w.p, line.segment_w.q}) {
    const Eigen::Vector3d end = T_kf_w * end_w;
    if (!(end.z() > camera.MinDepth())) return kMostSightError;
    const Eigen::Vector3d uvd = camera.ProjectStereo(end);
    error += Across(seen.left.segment, uvd.head<2>(), seen.sigma_px);
    if (!seen.HasDepth()) continue;
    const double sigma_px = std::hypot(seen.sigma_px, std::max(seen.sigma_disparity_p_px, seen.sigma_disparity_q_px));
    error += Across(RightSegment(seen), {uvd.x() - uvd.z(), uvd.y()}, sigma_px);
  }
  return Capped(error);
}

}  // namespace plslam
