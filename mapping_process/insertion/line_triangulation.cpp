// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/line_triangulation.h"

#include <cmath>
#include <numbers>

#include "core/features/matching/line_matcher.h"
#include "core/features/matching/segment_projection.h"
#include "core/localisation/projection_search.h"
#include "mapping_process/insertion/observations.h"

namespace plslam::mapping {
namespace {

constexpr double kMinOverlap = 0.3;
constexpr double kMaxAcross_px = 2.0;
constexpr int kNeighbours = 4;
constexpr size_t kMinObservations = 3;

Eigen::Vector3d Ray(const Eigen::Vector2d& px, const SegmentView& view, const StereoCamera& camera) {
  return view.T_w_kf.rotation() *
         Eigen::Vector3d((px.x() - camera.cx_px) / camera.f_px, (px.y() - camera.cy_px) / camera.f_px, 1.0);
}

// Unit normal, in the map frame, of the plane through the camera centre and the segment.
Eigen::Vector3d PlaneNormal(const SegmentView& view, const StereoCamera& camera) {
  return Ray(view.segment.p, view, camera).cross(Ray(view.segment.q, view, camera)).normalized();
}

bool Overlap(const Segment3& segment_w, const SegmentView& view, const StereoCamera& camera) {
  const SE3 T_kf_w = view.T_w_kf.Inverse();
  const Segment3 in_camera{T_kf_w * segment_w.p, T_kf_w * segment_w.q};
  if (in_camera.p.z() < camera.MinDepth() || in_camera.q.z() < camera.MinDepth()) return false;
  const auto s_p = AlongLine(in_camera, view.segment.p, camera);
  const auto s_q = AlongLine(in_camera, view.segment.q, camera);
  if (!s_p || !s_q || *s_p >= *s_q) return false;
  const double shared = std::min(*s_q, 1.0) - std::max(*s_p, 0.0);
  return shared >= kMinOverlap * std::min(1.0, *s_q - *s_p);
}

// Variance of the depth at which a pixel's ray in `first` meets the plane of `second`, by errors of the two poses.
double DepthVarianceOfPoses(const Eigen::Vector2d& px, double depth_m, const SegmentView& first,
                            const SegmentView& second, const StereoCamera& camera) {
  const Eigen::Vector3d ray = Ray(px, first, camera);
  const Eigen::Vector3d normal = PlaneNormal(second, camera);
  const Eigen::Vector3d ray_first = first.T_w_kf.R().transpose() * ray;
  const Eigen::Vector3d normal_first = first.T_w_kf.R().transpose() * normal;
  const Eigen::Vector3d normal_second = second.T_w_kf.R().transpose() * normal;
  const Eigen::Vector3d in_second = second.T_w_kf.Inverse() * (first.T_w_kf.translation() + depth_m * ray);
  Vector6d by_first, by_second;
  by_first << -normal_first, -depth_m * ray_first.cross(normal_first);
  by_second << normal_second, in_second.cross(normal_second);
  const double slope = normal.dot(ray);
  return (by_first.dot(first.covariance * by_first) + by_second.dot(second.covariance * by_second)) / (slope * slope);
}

// Covariance of the intersection of a pixel's ray in `first`, at depth `depth_m`, with the plane of `second`: the
// pixel's error moves it within that plane, the errors of the plane and of the poses along the ray.
Eigen::Matrix3d EndpointCovariance(const Eigen::Vector2d& px, double depth_m, const SegmentView& first,
                                   const SegmentView& second, const StereoCamera& camera) {
  const Eigen::Vector3d ray = Ray(px, first, camera);
  const Eigen::Vector3d normal = PlaneNormal(second, camera);
  const Eigen::Matrix3d slide = Eigen::Matrix3d::Identity() - ray * normal.transpose() / normal.dot(ray);
  const Eigen::Matrix<double, 3, 2> by_pixel =
      depth_m * first.sigma_px / camera.f_px * slide * first.T_w_kf.R().leftCols<2>();
  const SE3 T_second_w = second.T_w_kf.Inverse();
  const Eigen::Vector3d in_second = T_second_w * (first.T_w_kf.translation() + depth_m * ray);
  const double distance_px = std::sqrt(VarianceAcross(second.segment, camera.Project(in_second), second.sigma_px));
  const double per_px = in_second.z() / camera.f_px * (T_second_w.rotation() * normal).head<2>().norm();
  const Eigen::Vector3d by_plane = distance_px * per_px / normal.dot(ray) * ray;
  return by_pixel * by_pixel.transpose() + by_plane * by_plane.transpose() +
         DepthVarianceOfPoses(px, depth_m, first, second, camera) * ray * ray.transpose();
}

// Marks the lines of a keyframe without landmark and without stereo depth.
std::vector<char> WithoutDepth(KeyframeId keyframe_id, const FeaturesView& features, const Map& map) {
  std::vector<char> eligible;
  for (int32_t i = 0; i < static_cast<int32_t>(features.lines.size()); ++i) {
    const bool open = LandmarkAt<LineType>(map, {keyframe_id, i}) < 0;
    eligible.push_back(open && !features.lines[static_cast<size_t>(i)].HasDepth() ? 1 : 0);
  }
  return eligible;
}

std::vector<int> Places(const std::vector<char>& eligible) {
  std::vector<int> places;
  for (size_t i = 0; i < eligible.size(); ++i) {
    if (eligible[i] != 0) places.push_back(static_cast<int>(i));
  }
  return places;
}

std::vector<Descriptor> Descriptors(const std::vector<int>& places, std::span<const StereoLine> lines) {
  std::vector<Descriptor> descriptors;
  descriptors.reserve(places.size());
  for (const int place : places) descriptors.push_back(lines[static_cast<size_t>(place)].left.descriptor);
  return descriptors;
}

SegmentView ViewOf(const Observation& observation, const Matrix6d& pose_covariance, const KeyframeFeatures& features,
                   const Map& map) {
  const StereoLine& line = features.at(observation.keyframe_id()).lines[static_cast<size_t>(observation.feature)];
  return {map.FindKeyframe(observation.keyframe_id())->T_w_kf, pose_covariance, line.left.segment, line.sigma_px};
}

std::vector<KeyframeId> NeighbourIds(KeyframeId keyframe_id, const Map& map) {
  std::vector<KeyframeId> ids;
  for (const Map::Neighbour& neighbour : map.Neighbours(keyframe_id, Map::kCovisible)) {
    if (static_cast<int>(ids.size()) == kNeighbours) break;
    ids.push_back(neighbour.keyframe_id);
  }
  return ids;
}

/// Two segments with similar descriptors, of the new keyframe and of a neighbour.
struct LikePair {
  Observation own;
  Observation other;
};

std::vector<LikePair> FindLikePairs(KeyframeId keyframe_id, KeyframeId neighbour_id, const KeyframeFeatures& features,
                                    const LineMatchOptions& options, const Map& map) {
  const std::vector<int> own = Places(WithoutDepth(keyframe_id, features.at(keyframe_id), map));
  const std::vector<int> theirs = Places(WithoutDepth(neighbour_id, features.at(neighbour_id), map));
  const std::vector<int> match = MatchLinesBruteForce(Descriptors(own, features.at(keyframe_id).lines),
                                                      Descriptors(theirs, features.at(neighbour_id).lines), options);
  std::vector<LikePair> pairs;
  for (size_t i = 0; i < match.size(); ++i) {
    if (match[i] < 0) continue;
    pairs.push_back({{keyframe_id, own[i]}, {neighbour_id, theirs[static_cast<size_t>(match[i])]}});
  }
  return pairs;
}

MapLine MakeLandmark(LandmarkId id, const TriangulatedLine& triangulated, const Observation& observation,
                     const KeyframeFeatures& features) {
  MapLine line;
  line.id = id;
  line.segment_w = triangulated.segment_w;
  line.covariance_p = triangulated.covariance_p;
  line.covariance_q = triangulated.covariance_q;
  line.descriptor =
      features.at(observation.keyframe_id()).lines[static_cast<size_t>(observation.feature)].left.descriptor;
  line.observations = {observation};
  return line;
}

// Adds observations of other keyframes: unassociated segments near the projected line.
void AddObservationsOfOthers(LandmarkId line_id, const std::vector<KeyframeId>& keyframes,
                             const KeyframeFeatures& features, const StereoCamera& camera,
                             const MappingOptions& options, Map& map) {
  for (const KeyframeId id : keyframes) {
    if (IsSeenBy(*map.FindLine(line_id), id)) continue;
    const FeaturesView& seen = features.at(id);
    for (const LandmarkFeature& found :
         SearchLines(map, {line_id}, map.FindKeyframe(id)->T_w_kf, seen.lines, WithoutDepth(id, seen, map),
                     kMaxAcross_px, CameraOf(seen, camera), options.localisation)) {
      AddObservation<LineType>(line_id, {id, found.feature}, features, map);
    }
  }
}

}  // namespace

std::optional<TriangulatedLine> TriangulateLine(const SegmentView& first, const SegmentView& second,
                                                const StereoCamera& camera, double min_angle_rad,
                                                double max_relative_depth_sigma) {
  const Eigen::Vector3d n_first = PlaneNormal(first, camera);
  const Eigen::Vector3d n_second = PlaneNormal(second, camera);
  if (!(n_first.cross(n_second).norm() >= std::sin(min_angle_rad))) return std::nullopt;
  const Eigen::Vector3d between = second.T_w_kf.translation() - first.T_w_kf.translation();
  TriangulatedLine line;
  const auto place = [&](const Eigen::Vector2d& px, Eigen::Vector3d& end, Eigen::Matrix3d& covariance) {
    const Eigen::Vector3d ray = Ray(px, first, camera);
    const double depth_m = n_second.dot(between) / n_second.dot(ray);
    if (!(depth_m > camera.MinDepth()) || !std::isfinite(depth_m)) return false;
    end = first.T_w_kf.translation() + depth_m * ray;
    covariance = EndpointCovariance(px, depth_m, first, second, camera);
    const Eigen::Vector3d axis = first.T_w_kf.R().col(2);
    return covariance.allFinite() && std::sqrt(axis.dot(covariance * axis)) <= max_relative_depth_sigma * depth_m;
  };
  if (!place(first.segment.p, line.segment_w.p, line.covariance_p)) return std::nullopt;
  if (!place(first.segment.q, line.segment_w.q, line.covariance_q)) return std::nullopt;
  if (!Overlap(line.segment_w, second, camera)) return std::nullopt;
  return line;
}

std::vector<LandmarkId> TriangulateLines(KeyframeId keyframe_id, const Matrix6d& pose_covariance,
                                         const KeyframeFeatures& features, const StereoCamera& camera,
                                         const MappingOptions& options, LandmarkIds& ids, Map& map) {
  std::vector<LandmarkId> created;
  const std::vector<KeyframeId> neighbours = NeighbourIds(keyframe_id, map);
  const double min_angle_rad = options.insertion.min_plane_angle_deg * std::numbers::pi / 180.0;
  for (const KeyframeId neighbour_id : neighbours) {
    for (const LikePair& pair :
         FindLikePairs(keyframe_id, neighbour_id, features, options.localisation.line_matching, map)) {
      const auto triangulated = TriangulateLine(ViewOf(pair.own, pose_covariance, features, map),
                                                ViewOf(pair.other, pose_covariance, features, map), camera,
                                                min_angle_rad, options.insertion.max_relative_depth_sigma);
      if (!triangulated) continue;
      const LandmarkId id = ids.next_line++;
      map.Put(MakeLandmark(id, *triangulated, pair.own, features));
      AddObservation<LineType>(id, pair.other, features, map);
      AddObservationsOfOthers(id, neighbours, features, camera, options, map);
      // Any two viewing planes that meet define a line; a third view must confirm it.
      if (map.FindLine(id)->observations.size() >= kMinObservations) {
        created.push_back(id);
      } else {
        map.RemoveLine(id);
      }
    }
  }
  return created;
}

}  // namespace plslam::mapping
