// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/features/features.h"
#include "core/features/matching/descriptor_matcher.h"
#include "core/ids/ids.h"
#include "vo_process/stereo/rolling_shutter.h"

namespace plslam::vo {

/// Landmark of a feature.
struct FeatureTrack {
  TrackId landmark_id = -1;
  /// Frames in which the landmark has been observed; 0 for one created by this feature.
  int age = 0;
  /// The same landmark in the map, or -1, and the number of keyframes that observe it there.
  LandmarkId map_id = -1;
  int map_observations = 0;
  /// The moving body that the feature is on (`MovingBodies`), or -1 for the world.
  int body = -1;

  bool IsOfWorld() const { return body < 0; }
};

/// Landmark ids of features, in their order.
inline std::vector<TrackId> TrackedLandmarkIds(const std::vector<FeatureTrack>& tracks) {
  std::vector<TrackId> ids;
  ids.reserve(tracks.size());
  for (const FeatureTrack& track : tracks) ids.push_back(track.landmark_id);
  return ids;
}

/// The features of the frame being tracked, indexed by position, and their landmarks.
struct TrackedFrame {
  explicit TrackedFrame(StereoFeatures stereo)
      : features(std::move(stereo)),
        point_grid(features.points),
        point_tracks(features.points.size()),
        line_tracks(features.lines.size()) {}

  /// Moves the features to where a camera of this velocity observes them at the time of the stamp. Requires `rolling`.
  void MoveToStamp(const Vector6d& velocity) {
    const StereoFeatures before = std::move(features);
    features = rolling->MovedBy(velocity);
    for (size_t i = 0; i < before.points.size(); ++i) {
      raw_disparities_px[i] += features.points[i].disparity_px - before.points[i].disparity_px;
    }
    point_grid = PointGrid(features.points);
  }

  StereoFeatures features;
  /// Whether features were only followed, so that missing ones were not looked for.
  bool is_followed = false;
  /// The features as measured, if their rows are not simultaneous.
  std::optional<RollingFrame> rolling;
  /// Disparities of the points as measured; those of `features` are corrected (`DisparityCalibration`).
  std::vector<double> raw_disparities_px;
  /// Factor already applied to the sigmas of the points (`NoiseScale`).
  double point_sigma_scale = 1.0;
  PointGrid point_grid;
  /// In the order of `features.points` and `features.lines`.
  std::vector<FeatureTrack> point_tracks;
  std::vector<FeatureTrack> line_tracks;
};

/// A landmark and its feature: indices into the landmarks of one feature type and the frame's features.
struct LandmarkMatch {
  int landmark = -1;
  int feature = -1;
};

/// Matches from the result of a matcher: `found[i]` is the feature of landmark `owners[i]`, or -1.
inline std::vector<LandmarkMatch> PairUp(const std::vector<int>& owners, const std::vector<int>& found) {
  std::vector<LandmarkMatch> matches;
  for (size_t i = 0; i < found.size(); ++i) {
    if (found[i] >= 0) matches.push_back({owners[i], found[i]});
  }
  return matches;
}

/// Which landmarks to search, and in what radius around their projection.
struct Search {
  double radius_px = 0.0;
  /// Landmarks unseen for longer are skipped.
  int max_unseen_frames = 0;
};

}  // namespace plslam::vo
