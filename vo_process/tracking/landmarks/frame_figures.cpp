// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/landmarks/frame_figures.h"

#include <algorithm>
#include <vector>

#include "core/motion/robust.h"

namespace plslam::vo {

// Landmarks that a frame could create: points with depth, lines with depth twice.
int CreatableLandmarks(const StereoFeatures& features) {
  const auto has_depth = [](const auto& feature) { return feature.HasDepth(); };
  return static_cast<int>(std::count_if(features.points.begin(), features.points.end(), has_depth) +
                          2 * std::count_if(features.lines.begin(), features.lines.end(), has_depth));
}

double MedianDepth(const TrackedFrame& frame, const StereoCamera& camera) {
  std::vector<double> disparities;
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    const StereoPoint& point = frame.features.points[i];
    if (point.HasDepth() && frame.point_tracks[i].IsOfWorld()) disparities.push_back(point.disparity_px);
  }
  for (size_t i = 0; i < frame.features.lines.size(); ++i) {
    const StereoLine& line = frame.features.lines[i];
    if (line.HasDepth() && frame.line_tracks[i].IsOfWorld()) disparities.push_back(line.MiddleDisparity_px());
  }
  return disparities.empty() ? 0.0 : camera.Depth(Median(disparities));
}

double KnownShare(const TrackedFrame& frame, int observations) {
  int found = 0;
  int known = 0;
  const auto count = [&](const std::vector<FeatureTrack>& tracks, int weight) {
    for (const FeatureTrack& track : tracks) {
      if (track.landmark_id < 0 || track.age == 0 || !track.IsOfWorld()) continue;
      found += weight;
      if (track.map_observations >= observations) known += weight;
    }
  };
  count(frame.point_tracks, 1);
  count(frame.line_tracks, 2);
  return found == 0 ? 0.0 : static_cast<double>(known) / found;
}

}  // namespace plslam::vo
