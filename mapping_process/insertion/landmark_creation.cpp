// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/landmark_creation.h"

#include <optional>

#include "core/geometry/triangulation.h"

namespace plslam::mapping {
namespace {

// Shorter segments have no usable direction, and matchers reject them.
constexpr double kMinLength_px = 1.0;

bool IsSure(double disparity_px, double sigma_disparity_px, const InsertionOptions& options) {
  return disparity_px > 0.0 && sigma_disparity_px <= options.max_relative_depth_sigma * disparity_px;
}

std::optional<MapPoint> MakePoint(const StereoPoint& seen, const SE3& T_w_kf, const StereoCamera& camera,
                                  const InsertionOptions& options) {
  if (!IsSure(seen.disparity_px, seen.sigma_disparity_px, options)) return std::nullopt;
  const Eigen::Vector3d uvd(seen.left.px.x(), seen.left.px.y(), seen.disparity_px);
  const Eigen::Vector3d p_c = camera.Backproject(uvd);
  MapPoint point;
  point.p_w = T_w_kf * p_c;
  point.covariance =
      RotateCovariance(T_w_kf.R(), camera.BackprojectCovariance(uvd, seen.sigma_px, seen.sigma_disparity_px));
  point.descriptor = seen.left.descriptor;
  point.angle_rad = seen.left.angle_rad;
  point.octave = seen.left.octave;
  point.depth_m = camera.OctaveScale() * p_c.z();
  return point;
}

std::optional<MapLine> MakeLine(const StereoLine& seen, const SE3& T_w_kf, const StereoCamera& camera,
                                const InsertionOptions& options) {
  if (!(seen.left.segment.Length() >= kMinLength_px)) return std::nullopt;
  if (!IsSure(seen.disparity_p_px, seen.sigma_disparity_p_px, options)) return std::nullopt;
  if (!IsSure(seen.disparity_q_px, seen.sigma_disparity_q_px, options)) return std::nullopt;
  const Segment2& segment = seen.left.segment;
  const Eigen::Vector3d p(segment.p.x(), segment.p.y(), seen.disparity_p_px);
  const Eigen::Vector3d q(segment.q.x(), segment.q.y(), seen.disparity_q_px);
  const Eigen::Matrix3d R = T_w_kf.R();
  MapLine line;
  line.segment_w = {T_w_kf * camera.Backproject(p), T_w_kf * camera.Backproject(q)};
  line.covariance_p = RotateCovariance(R, camera.BackprojectCovariance(p, seen.sigma_px, seen.sigma_disparity_p_px));
  line.covariance_q = RotateCovariance(R, camera.BackprojectCovariance(q, seen.sigma_px, seen.sigma_disparity_q_px));
  line.descriptor = seen.left.descriptor;
  return line;
}

template <class Type, class Make>
std::vector<LandmarkId> CreateKind(KeyframeId keyframe_id, const FeaturesView& features, const Make& make,
                                   LandmarkId& next_id, Map& map) {
  std::vector<LandmarkId> created;
  const auto& list = Type::Features(features);
  for (int32_t i = 0; i < static_cast<int32_t>(list.size()); ++i) {
    const Observation observation{keyframe_id, i};
    if (LandmarkAt<Type>(map, observation) >= 0) continue;
    auto landmark = make(list[static_cast<size_t>(i)]);
    if (!landmark) continue;
    landmark->id = next_id++;
    landmark->observations = {observation};
    map.Put(*landmark);
    created.push_back(landmark->id);
  }
  return created;
}

}  // namespace

NewLandmarks CreateLandmarks(KeyframeId keyframe_id, const FeaturesView& features, const StereoCamera& camera,
                             const InsertionOptions& options, LandmarkIds& ids, Map& map) {
  const SE3 T_w_kf = map.FindKeyframe(keyframe_id)->T_w_kf;
  const auto make_point = [&](const StereoPoint& seen) { return MakePoint(seen, T_w_kf, camera, options); };
  const auto make_line = [&](const StereoLine& seen) { return MakeLine(seen, T_w_kf, camera, options); };
  return {CreateKind<PointType>(keyframe_id, features, make_point, ids.next_point, map),
          CreateKind<LineType>(keyframe_id, features, make_line, ids.next_line, map)};
}

}  // namespace plslam::mapping
