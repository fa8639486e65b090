// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <map>

#include "core/ids/ids.h"
#include "tests/support/feature_world.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::test {

/// The frame of the map in these tests.
inline const SE3 kT_w_world(ExpSO3(Eigen::Vector3d(0.2, 0.1, -0.4)), Eigen::Vector3d(5.0, -2.0, 1.0));

/// A bending way through a world.
inline SE3 PoseAt(int frame) {
  const double s = 0.02 * frame;
  return SE3(ExpSO3(Eigen::Vector3d(0.05 * std::sin(s), 0.6 * s, 0.0)),
             Eigen::Vector3d(0.5 * std::sin(s), 0.1 * s, 0.8 * (1.0 - std::cos(s))));
}

inline StereoFeatures See(const FeatureWorld& world, int frame, double noise_px) {
  return world.Observe(PoseAt(frame), noise_px, static_cast<uint64_t>(frame));
}

/// The map of a perfect mapping_process: it identifies landmarks by their descriptors, and has their true positions.
class PerfectMap {
 public:
  /// `world`: the visible features of the keyframe's frame. `shift_w` moves all new landmarks.
  explicit PerfectMap(const FeatureWorld& world, const Eigen::Vector3d& shift_w = Eigen::Vector3d::Zero())
      : world_(world), shift_w_(shift_w) {}

  /// `error`: of the keyframe's pose, not of its landmarks.
  void Add(SessionId session, int frame, const vo::OdometryResult& result, const SE3& error = {}) {
    MapKeyframe keyframe;
    keyframe.id = next_id_++;
    keyframe.name.session = session;
    keyframe.name.number = result.keyframe->id;
    const SE3 T_w_c = kT_w_world * PoseAt(frame);
    keyframe.T_w_kf = T_w_c * error;
    keyframe.T_odom_kf = result.T_odom_c;
    map_.Put(keyframe);
    const StereoFeatures truth = See(world_, frame, 0.0);
    const StereoFeatures& features = result.keyframe->content.features;
    for (size_t i = 0; i < features.points.size(); ++i) {
      for (const StereoPoint& exact : truth.points) {
        if (exact.left.descriptor == features.points[i].left.descriptor) Observationed(keyframe.id, T_w_c, i, exact);
      }
    }
    for (size_t i = 0; i < features.lines.size(); ++i) {
      for (const StereoLine& exact : truth.lines) {
        if (exact.left.descriptor == features.lines[i].left.descriptor) Observationed(keyframe.id, T_w_c, i, exact);
      }
    }
  }

  const Map& map() const { return map_; }

 private:
  void Observationed(KeyframeId keyframe_id, const SE3& T_w_c, size_t feature, const StereoPoint& exact) {
    const auto [known, is_new] = points_.try_emplace(exact.left.descriptor);
    MapPoint& point = known->second;
    if (is_new) {
      point.id = LandmarkId(points_.size() - 1);
      point.p_w = shift_w_ + T_w_c * Backproject(exact.left.px, exact.disparity_px);
      point.covariance = 1e-6 * Eigen::Matrix3d::Identity();
      point.descriptor = exact.left.descriptor;
      point.depth_m = FeatureWorld::Camera().Depth(exact.disparity_px);
    }
    if (!point.observations.empty() && point.observations.back().keyframe_id() == keyframe_id) return;
    point.observations.push_back({keyframe_id, static_cast<int32_t>(feature)});
    map_.Put(point);
  }
  void Observationed(KeyframeId keyframe_id, const SE3& T_w_c, size_t feature, const StereoLine& exact) {
    if (!exact.HasDepth()) return;
    const auto [known, is_new] = lines_.try_emplace(exact.left.descriptor);
    MapLine& line = known->second;
    if (is_new) {
      line.id = LandmarkId(lines_.size() - 1);
      line.segment_w.p = shift_w_ + T_w_c * Backproject(exact.left.segment.p, exact.disparity_p_px);
      line.segment_w.q = shift_w_ + T_w_c * Backproject(exact.left.segment.q, exact.disparity_q_px);
      line.covariance_p = line.covariance_q = 1e-6 * Eigen::Matrix3d::Identity();
      line.descriptor = exact.left.descriptor;
    }
    if (!line.observations.empty() && line.observations.back().keyframe_id() == keyframe_id) return;
    line.observations.push_back({keyframe_id, static_cast<int32_t>(feature)});
    map_.Put(line);
  }
  static Eigen::Vector3d Backproject(const Eigen::Vector2d& px, double disparity_px) {
    return FeatureWorld::Camera().Backproject({px.x(), px.y(), disparity_px});
  }

  const FeatureWorld& world_;
  Eigen::Vector3d shift_w_;
  Map map_;
  std::map<Descriptor, MapPoint> points_;
  std::map<Descriptor, MapLine> lines_;
  KeyframeId next_id_ = 0;
};

}  // namespace plslam::test
