// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/localisation/options.h"
#include "core/map/keyframe.h"
#include "core/map/landmark_types.h"

namespace plslam {

/// Landmark of the map of each feature of a keyframe, or -1; each landmark at most once. Same length as the features.
struct Association {
  std::vector<LandmarkId> points;
  std::vector<LandmarkId> lines;

  /// Inlier score: lines count twice, because each has two endpoints.
  int Weight() const;
};

/// Returns the keyframe and its best neighbours that share at least `min_shared` landmarks with it; most shared first,
/// at most `max_keyframes` (>= 1) in total.
std::vector<KeyframeId> KeyframesAround(KeyframeId keyframe_id, const Map& map, int min_shared, int max_keyframes);

/// Ids of the landmarks to search for.
struct LocalMap {
  std::vector<LandmarkId> points;
  std::vector<LandmarkId> lines;
};

/// Returns the landmarks observed by the best-connected keyframes of the associated landmarks (PL-SLAM §V.A), except
/// those already associated. Without associations (the tracker was lost, or sends no ids), the landmarks observed by
/// `previous_id` (-1: none) and its predecessors in the session.
LocalMap LocalMapOf(const Association& association, KeyframeId previous_id, const Map& map, int max_keyframes);

/// Guided matching by projection: searches the landmarks among the features without landmark, and adds the matches to
/// the association.
void SearchByProjection(const Map& map, const LocalMap& local, const SE3& T_w_kf, const FeaturesView& features,
                        const StereoCamera& camera, const LocalisationOptions& options, Association& association);

/// Cells of a grid over the image, by which the spread of landmarks in the view is counted.
constexpr int kViewGrid = 4;
constexpr size_t kViewCells = size_t{kViewGrid} * kViewGrid;

/// Returns the index of the cell at `px`, row by row; pixels outside belong to the nearest cell.
size_t ViewCell(const Eigen::Vector2d& px, const StereoCamera& camera);

/// Number of landmarks of a keyframe that are expected in the image of a camera, and of those that are associated.
/// Lines count twice.
struct ExpectedLandmarks {
  int expected = 0;
  int found = 0;
  /// Cells of the view that expect at least ten, and those in which at least a tenth is associated.
  int cells = 0;
  int cells_shown = 0;

  double Share() const { return expected > 0 ? static_cast<double>(found) / expected : 0.0; }
};

/// Counts the landmarks of a keyframe of the map that a camera at `T_w_c` should see (projected into the image, in
/// front of the camera), and those among them that are associated. `camera` is that of the features (`CameraOf`).
ExpectedLandmarks CountExpected(const Map& map, KeyframeId keyframe_id, const SE3& T_w_c, const StereoCamera& camera,
                                const Association& association);

}  // namespace plslam
