// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/map/landmark_types.h"
#include "tests/support/feature_world.h"

namespace plslam::test {

/// A map made by hand: keyframes with features, and landmarks at positions chosen by a test.
struct HandmadeMap {
  Map map;
  KeyframeFeatures features;

  KeyframeId AddKeyframe(const SE3& T_w_kf, StereoFeatures seen = {}) {
    MapKeyframe keyframe;
    keyframe.id = KeyframeId(features.size());
    keyframe.name.number = keyframe.id.value;
    keyframe.previous_id = keyframe.parent_id = KeyframeId(keyframe.id.value - 1);
    keyframe.T_w_kf = T_w_kf;
    if (keyframe.id > 0) {
      keyframe.T_prevkf_kf = map.FindKeyframe(keyframe.previous_id)->T_w_kf.Inverse() * T_w_kf;
      keyframe.relative_covariance = 1e-4 * Matrix6d::Identity();
    }
    map.Put(keyframe);
    features[keyframe.id] = std::move(seen);
    return keyframe.id;
  }

  /// A new feature of the keyframe where the point or segment is seen without noise.
  Observation SeePoint(KeyframeId keyframe_id, const Eigen::Vector3d& p_w, const Descriptor& descriptor) {
    const Eigen::Vector3d uvd =
        FeatureWorld::Camera().ProjectStereo(map.FindKeyframe(keyframe_id)->T_w_kf.Inverse() * p_w);
    StereoPoint seen;
    seen.left.px = uvd.head<2>();
    seen.left.descriptor = descriptor;
    seen.disparity_px = uvd.z();
    seen.sigma_px = seen.sigma_disparity_px = 0.5;
    ChangeFeatures(features, keyframe_id, [&](StereoFeatures& of) { of.points.push_back(seen); });
    return {keyframe_id, static_cast<int32_t>(features[keyframe_id].points.size()) - 1};
  }
  Observation SeeLine(KeyframeId keyframe_id, const Segment3& segment_w, const Descriptor& descriptor) {
    const SE3 T_kf_w = map.FindKeyframe(keyframe_id)->T_w_kf.Inverse();
    const Eigen::Vector3d p = FeatureWorld::Camera().ProjectStereo(T_kf_w * segment_w.p);
    const Eigen::Vector3d q = FeatureWorld::Camera().ProjectStereo(T_kf_w * segment_w.q);
    StereoLine seen;
    seen.left.segment = {p.head<2>(), q.head<2>()};
    seen.left.descriptor = descriptor;
    seen.disparity_p_px = p.z();
    seen.disparity_q_px = q.z();
    seen.sigma_px = seen.sigma_disparity_p_px = seen.sigma_disparity_q_px = 0.5;
    ChangeFeatures(features, keyframe_id, [&](StereoFeatures& of) { of.lines.push_back(seen); });
    return {keyframe_id, static_cast<int32_t>(features[keyframe_id].lines.size()) - 1};
  }

  void PutPoint(LandmarkId id, const Eigen::Vector3d& p_w, const Descriptor& descriptor,
                std::vector<Observation> observations) {
    MapPoint point;
    point.id = id;
    point.p_w = p_w;
    point.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    point.descriptor = descriptor;
    point.depth_m = (map.FindKeyframe(observations.back().keyframe_id())->T_w_kf.Inverse() * p_w).z();
    point.observations = std::move(observations);
    map.Put(point);
  }
  void PutLine(LandmarkId id, const Segment3& segment_w, const Descriptor& descriptor,
               std::vector<Observation> observations) {
    MapLine line;
    line.id = id;
    line.segment_w = segment_w;
    line.covariance_p = line.covariance_q = 1e-4 * Eigen::Matrix3d::Identity();
    line.descriptor = descriptor;
    line.observations = std::move(observations);
    map.Put(line);
  }

  /// `n` points in front of the keyframes that see them, which ties these together; ids from `first_id`.
  void Tie(const std::vector<KeyframeId>& keyframes, int n, int first_id,
           const std::vector<Descriptor>& descriptors) {
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector3d p_w(0.2 * (i % 10) - 0.9, 0.2 * (i / 10 % 8) - 0.7, 4.0 + 0.1 * (i % 7));
      const Descriptor& descriptor = descriptors[static_cast<size_t>(first_id + i)];
      std::vector<Observation> observations;
      for (const KeyframeId id : keyframes) observations.push_back(SeePoint(id, p_w, descriptor));
      PutPoint(first_id + i, p_w, descriptor, observations);
    }
  }
};

}  // namespace plslam::test
