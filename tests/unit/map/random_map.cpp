// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/map/random_map.h"

#include <algorithm>
#include <iterator>
#include <map>

namespace plslam::test {
namespace {

constexpr int kFeatures = 60;
constexpr uint64_t kNewest = 12;

}  // namespace

SE3 RandomMap::DrawPose() {
  Vector6d x;
  for (double& value : x) value = static_cast<double>(Draw(2001)) * 1e-3 - 1.0;
  return SE3::Exp(x);
}

Eigen::Matrix3d RandomMap::DrawCovariance() {
  Eigen::Matrix3d root;
  for (double& value : root.reshaped()) value = static_cast<double>(Draw(1000)) * 1e-4;
  return root * root.transpose();
}

template <class AnId, class Value>
const Value& RandomMap::DrawFrom(const IdMap<AnId, Value>& values) {
  return std::next(values.begin(), static_cast<std::ptrdiff_t>(Draw(values.size())))->second;
}

/// In some of the newest keyframes.
std::vector<Observation> RandomMap::DrawObservations() {
  std::vector<Observation> observations;
  auto keyframe = map_.keyframes().rbegin();
  for (uint64_t i = 0; i < kNewest && keyframe != map_.keyframes().rend(); ++i, ++keyframe) {
    if (Draw(3) == 0) observations.push_back({keyframe->first, static_cast<int32_t>(Draw(kFeatures))});
  }
  if (observations.empty())
    observations.push_back({map_.keyframes().rbegin()->first, static_cast<int32_t>(Draw(kFeatures))});
  if (observations.front().keyframe_id() > observations.back().keyframe_id())
    std::reverse(observations.begin(), observations.end());
  return observations;
}

void RandomMap::AddKeyframe() {
  MapKeyframe keyframe;
  keyframe.id = next_keyframe_++;
  keyframe.name.session = 7;
  keyframe.name.number = keyframe.id.value;
  keyframe.frame_id = FrameId(5 * keyframe.id.value);
  keyframe.t_ns = 1000 * keyframe.id.value;
  keyframe.T_w_kf = DrawPose();
  keyframe.T_odom_kf = DrawPose();
  keyframe.T_prevkf_kf = DrawPose();
  keyframe.covariance.setIdentity();
  keyframe.covariance *= 1e-3 * static_cast<double>(Draw(100));
  if (!map_.keyframes().empty()) {
    keyframe.previous_id = map_.keyframes().rbegin()->first;
    keyframe.parent_id = DrawFrom(map_.keyframes()).id;
  }
  if (keyframe.id.value % 3 == 0) keyframe.up = UpDirection{DrawPose().rotation() * Eigen::Vector3d::UnitX(), 0.01};
  map_.Put(keyframe);
}

void RandomMap::Place(MapPoint& point) {
  point.p_w = DrawPose().translation();
  point.covariance = DrawCovariance();
  point.descriptor = {random_(), random_(), random_(), random_()};
  point.angle_rad = static_cast<float>(Draw(6));
  point.octave = static_cast<int>(Draw(8));
  point.depth_m = 1.0 + static_cast<double>(Draw(100)) / 7.0;
}

void RandomMap::Place(MapLine& line) {
  line.segment_w = {DrawPose().translation(), DrawPose().translation()};
  line.covariance_p = DrawCovariance();
  line.covariance_q = DrawCovariance();
  line.descriptor = {random_(), random_(), random_(), random_()};
}

/// A new landmark, or another state of an old one.
template <class Landmark>
void RandomMap::Change(const IdMap<LandmarkId, Landmark>& landmarks, LandmarkId& next_id) {
  Landmark landmark;
  if (landmarks.empty() || Draw(2) == 0) {
    landmark.id = next_id++;
  } else {
    landmark = DrawFrom(landmarks);
  }
  if (landmark.observations.empty() || Draw(2) == 0) landmark.observations = DrawObservations();
  Place(landmark);
  map_.Put(landmark);
}

/// One of two takes the observations of both; in a keyframe that has both, its own.
template <class Landmark>
void RandomMap::Fuse(const IdMap<LandmarkId, Landmark>& landmarks) {
  if (landmarks.size() < 2) return;
  const Landmark gone = DrawFrom(landmarks);
  Landmark stays = DrawFrom(landmarks);
  if (gone.id == stays.id) return;
  std::map<KeyframeId, int32_t> observations;
  for (const Observation& observation : stays.observations)
    observations.emplace(observation.keyframe_id(), observation.feature);
  for (const Observation& observation : gone.observations)
    observations.emplace(observation.keyframe_id(), observation.feature);
  stays.observations.clear();
  for (const auto& [keyframe_id, feature] : observations) stays.observations.push_back({keyframe_id, feature});
  if (Draw(2) == 0) {
    Remove(gone);
    map_.Put(stays);
  } else {
    map_.Put(stays);
    Remove(gone);
  }
}

void RandomMap::CloseLoop() {
  const KeyframeId newest = map_.keyframes().rbegin()->first;
  if (newest == 0) return;
  map_.Add({KeyframeId(Draw(static_cast<uint64_t>(newest.value))), newest, DrawPose(), 1e-4 * Matrix6d::Identity(),
            static_cast<int32_t>(Draw(100)), static_cast<int32_t>(Draw(20))});
}

/// Some keyframes, some of them to their current pose, and some that do not exist.
void RandomMap::Move() {
  std::map<KeyframeId, SE3> poses{{KeyframeId(next_keyframe_.value + 5), DrawPose()}};
  for (const auto& [id, keyframe] : map_.keyframes()) {
    if (Draw(3) == 0) poses[id] = Draw(4) == 0 ? keyframe.T_w_kf : DrawPose();
  }
  map_.Move(poses);
  std::map<KeyframeId, Matrix6d> covariances;
  for (const auto& [id, keyframe] : map_.keyframes()) {
    if (Draw(3) == 0) covariances[id] = 1e-3 * static_cast<double>(Draw(100)) * Matrix6d::Identity();
  }
  map_.SetCovariances(covariances);
}

void RandomMap::Step() {
  if (map_.keyframes().empty()) return AddKeyframe();
  switch (Draw(46)) {
    case 0:
    case 1:
      return AddKeyframe();
    case 2:
      return Fuse(map_.points());
    case 3:
      return Fuse(map_.lines());
    case 4:
      if (!map_.points().empty()) Remove(DrawFrom(map_.points()));
      return;
    case 5:
      if (!map_.lines().empty()) Remove(DrawFrom(map_.lines()));
      return;
    case 6: {
      const KeyframeId id = DrawFrom(map_.keyframes()).id;
      if (id != 0 && Draw(3) == 0) map_.RemoveKeyframe(id);
      return;
    }
    case 7:
      return map_.SetPose(DrawFrom(map_.keyframes()).id, DrawPose(), Matrix6d::Identity());
    case 8:
      if (!map_.points().empty()) {
        map_.SetPosition(DrawFrom(map_.points()).id, DrawPose().translation(), DrawCovariance());
      }
      return;
    case 9:
      if (!map_.lines().empty()) {
        const Segment3 segment = {DrawPose().translation(), DrawPose().translation()};
        map_.SetSegment(DrawFrom(map_.lines()).id, segment, DrawCovariance(), DrawCovariance());
      }
      return;
    case 10:
      return CloseLoop();
    case 11:
      return Move();
    default:
      return Draw(2) == 0 ? Change(map_.points(), next_point_) : Change(map_.lines(), next_line_);
  }
}

void RandomMap::Steps(int n) {
  for (int i = 0; i < n; ++i) Step();
}

}  // namespace plslam::test
