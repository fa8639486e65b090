// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/export/small_map.h"

#include <cmath>
#include <vector>

#include "core/io/maps/map_camera.h"

namespace plslam::test {
namespace {

constexpr int kKeyframes = 3;
constexpr int kPoints = 60;
constexpr int kLines = 4;
constexpr int kAlone = 100;

MapKeyframe KeyframeAt(int i) {
  MapKeyframe keyframe;
  keyframe.name.number = i;
  keyframe.id = KeyframeId(keyframe.name.number);
  keyframe.frame_id = 10 * i;
  keyframe.t_ns = 1'000'000'000LL * i + 5;
  keyframe.T_w_kf = SE3(ExpSO3({0.02 * i, 0.05 * i, -0.01 * i}), {0.3 * i, -0.05 * i, 0.4 * i});
  keyframe.covariance = keyframe.relative_covariance = 1e-4 * Matrix6d::Identity();
  keyframe.T_odom_kf = keyframe.T_w_kf;
  keyframe.previous_id = keyframe.parent_id = i - 1;
  if (i > 0) keyframe.T_prevkf_kf = KeyframeAt(i - 1).T_w_kf.Inverse() * keyframe.T_w_kf;
  return keyframe;
}

Eigen::Vector3d PointAt(int i) { return {0.25 * (i % 10) - 1.2, 0.3 * (i / 10) - 0.8, 6.0 + std::sin(1.7 * i)}; }

StereoPoint Seen(const SE3& T_w_kf, const Eigen::Vector3d& p_w) {
  const Eigen::Vector3d uvd = SmallCamera().ProjectStereo(T_w_kf.Inverse() * p_w);
  StereoPoint point;
  point.left.px = uvd.head<2>();
  point.disparity_px = uvd.z();
  return point;
}

StereoLine Seen(const SE3& T_w_kf, const Segment3& segment_w) {
  const StereoPoint p = Seen(T_w_kf, segment_w.p), q = Seen(T_w_kf, segment_w.q);
  StereoLine line;
  line.left.segment = {p.left.px, q.left.px};
  line.disparity_p_px = p.disparity_px;
  line.disparity_q_px = q.disparity_px;
  return line;
}

Segment3 SegmentAt(int i) { return {{-1.0, 0.4 * i - 0.6, 7.0}, {1.0, 0.4 * i - 0.5, 7.5}}; }

StereoFeatures FeaturesOf(const SE3& T_w_kf) {
  StereoFeatures features;
  for (int i = 0; i < kPoints; ++i) features.points.push_back(Seen(T_w_kf, PointAt(i)));
  features.points.push_back(Seen(T_w_kf, PointAt(kAlone)));
  features.points.push_back(Seen(T_w_kf, {0.1, 0.1, 9.0}));
  for (int i = 0; i < kLines; ++i) features.lines.push_back(Seen(T_w_kf, SegmentAt(i)));
  return features;
}

std::vector<Observation> SeenByAll(int feature) {
  std::vector<Observation> observations;
  for (int i = 0; i < kKeyframes; ++i) observations.push_back({i, feature});
  return observations;
}

void PutLandmarks(Map& map) {
  MapPoint point;
  for (int i = 0; i < kPoints; ++i) {
    point.id = i;
    point.p_w = PointAt(i);
    point.observations = SeenByAll(i);
    map.Put(point);
  }
  point.id = kAlone;
  point.p_w = PointAt(kAlone);
  point.observations = {{0, kPoints}};
  map.Put(point);
  MapLine line;
  for (int i = 0; i < kLines; ++i) {
    line.id = i;
    line.segment_w = SegmentAt(i);
    line.observations = SeenByAll(i);
    map.Put(line);
  }
}

}  // namespace

StereoCamera SmallCamera() { return {400.0, 320.0, 240.0, 0.12, 640, 480}; }

StoredMap SmallStoredMap() {
  StoredMap stored;
  stored.rig = CameraBytes(SmallCamera());
  for (int i = 0; i < kKeyframes; ++i) {
    const MapKeyframe keyframe = KeyframeAt(i);
    stored.map.Put(keyframe);
    stored.features[i] = FeaturesOf(keyframe.T_w_kf);
  }
  PutLandmarks(stored.map);
  stored.map.TakeChanges();
  stored.next_keyframe_id = kKeyframes;
  stored.next_point_id = kAlone + 1;
  stored.next_line_id = kLines;
  stored.sessions[0] = {kKeyframes - 1, kKeyframes - 1};
  return stored;
}

}  // namespace plslam::test
