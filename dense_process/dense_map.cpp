// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/dense_map.h"

#include <limits>

namespace plslam::dense {
namespace {

// A submap ends after so many keyframes, or at this distance from its anchor, in voxels: over that length the local map
// is rigid to a fraction of a voxel.
constexpr int kMostKeyframes = 10;
constexpr double kLargest = 60.0;

}  // namespace

KeyframePoses PosesOf(const Map& map) {
  KeyframePoses poses;
  for (const RemovedKeyframe& keyframe : map.RemovedKeyframes()) {
    poses[{keyframe.session, keyframe.frame_id}] = keyframe.T_w_kf;
  }
  for (const auto& [id, keyframe] : map.keyframes()) poses[{keyframe.session, keyframe.frame_id}] = keyframe.T_w_kf;
  return poses;
}

size_t DenseMap::bytes() const {
  size_t bytes = 0;
  for (const Submap& submap : submaps_) bytes += submap.volume.bytes();
  return bytes;
}

bool DenseMap::Continues(const KeyframeName& keyframe, const SE3& T_w_kf, const KeyframePoses& poses) const {
  if (submaps_.empty()) return false;
  const Submap& newest = submaps_.back();
  const auto anchor = poses.find(newest.anchor);
  if (anchor == poses.end() || newest.anchor.first != keyframe.first || newest.n_keyframes >= kMostKeyframes) {
    return false;
  }
  return (T_w_kf.translation() - anchor->second.translation()).norm() < kLargest * voxel_m_;
}

bool DenseMap::Add(const KeyframeName& keyframe, const DepthImage& depth, const cv::Mat& grey,
                   const StereoCamera& camera, const KeyframePoses& poses) {
  const auto pose = poses.find(keyframe);
  if (pose == poses.end()) return false;
  const SE3& T_w_kf = pose->second;
  if (!Continues(keyframe, T_w_kf, poses)) submaps_.push_back({keyframe, T_w_kf, 0, Volume(voxel_m_)});
  Submap& submap = submaps_.back();
  const SE3 T_s_kf = submap.T_s_anchor * poses.at(submap.anchor).Inverse() * T_w_kf;
  const double range_m = range_m_ > 0.0 ? range_m_ : std::numeric_limits<double>::infinity();
  submap.volume.Integrate(T_s_kf.translation(), MakeRays(depth, grey, camera, T_s_kf, voxel_m_, range_m));
  ++submap.n_keyframes;
  ++n_keyframes_;
  return true;
}

Volume DenseMap::Merge(const KeyframePoses& poses, const SE3& T_a_w) const {
  Volume merged(voxel_m_);
  for (const Submap& submap : submaps_) {
    const auto anchor = poses.find(submap.anchor);
    if (anchor == poses.end()) continue;
    merged.Add(submap.volume, T_a_w * anchor->second * submap.T_s_anchor.Inverse());
  }
  return merged;
}

}  // namespace plslam::dense
