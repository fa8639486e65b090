// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/keyframe_poses.h"

#include <algorithm>
#include <vector>

namespace plslam::dense {

KeyframePoses LastingPosesOf(const Map& map) {
  KeyframePoses poses;
  for (const auto& [id, keyframe] : map.keyframes())
    poses[{keyframe.name.session, keyframe.frame_id}] = keyframe.T_w_kf;
  return poses;
}

KeyframePoses PosesOf(const Map& map) {
  KeyframePoses poses = LastingPosesOf(map);
  for (const RemovedKeyframe& keyframe : map.RemovedKeyframes()) {
    // The map's own pose stays if a keyframe is in both.
    poses.try_emplace({keyframe.session, keyframe.frame_id}, keyframe.T_w_kf);
  }
  return poses;
}

std::set<KeyframeId> RemovedToForget(const std::vector<RemovedKeyframe>& removed, size_t most,
                                     const std::set<KeyframeFrame>& needed) {
  std::set<KeyframeId> ids;
  if (removed.size() <= most) return ids;
  const size_t n = removed.size() - most + most / 10;
  for (const RemovedKeyframe& keyframe : removed) {
    if (ids.size() == n) break;
    if (!needed.contains({keyframe.session, keyframe.frame_id})) ids.insert(keyframe.id);
  }
  return ids;
}

std::optional<KeyframeFrame> NearestKeyframe(const KeyframePoses& poses, const SE3& T_w_kf) {
  const auto distance = [&](const auto& other) {
    return (other.second.translation() - T_w_kf.translation()).squaredNorm();
  };
  const auto nearest = std::ranges::min_element(poses, {}, distance);
  return nearest == poses.end() ? std::nullopt : std::optional(nearest->first);
}

SeenSurface SeenBy(const KeyframePoses& poses, const StereoCamera& camera, double range_m,
                   std::span<const Eigen::Vector3d> points_w) {
  SeenSurface seen;
  if (points_w.empty()) return seen;
  std::vector<bool> is_seen(points_w.size(), false);
  for (const auto& [name, T_w_kf] : poses) {
    const SE3 T_kf_w = T_w_kf.Inverse();
    int n = 0;
    for (size_t i = 0; i < points_w.size(); ++i) {
      const Eigen::Vector3d p = T_kf_w * points_w[i];
      if (p.z() < camera.MinDepth() || p.z() > range_m) continue;
      const double u = camera.f_px * p.x() / p.z() + camera.cx_px, v = camera.f_px * p.y() / p.z() + camera.cy_px;
      if (u < 0.0 || v < 0.0 || u >= camera.width_px || v >= camera.height_px) continue;
      is_seen[i] = true;
      ++n;
    }
    if (n > 0) seen.n_points[name] = n;
  }
  const auto n_seen = std::ranges::count(is_seen, true);
  seen.share = static_cast<double>(n_seen) / static_cast<double>(points_w.size());
  return seen;
}

}  // namespace plslam::dense
