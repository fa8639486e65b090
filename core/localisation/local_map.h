// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/localisation/options.h"
#include "core/map/keyframe.h"
#include "core/map/landmark_types.h"

namespace plslam {

/// The landmark of the map that each feature of a keyframe shows, or -1; no landmark twice. As long as the features.
struct Association {
  std::vector<int64_t> points;
  std::vector<int64_t> lines;

  /// Lines count twice: each has two endpoints.
  int Weight() const;
};

/// The keyframe and its best neighbours in covisibility, those that share at least `min_shared` landmarks with it;
/// most shared first, at most `max_keyframes` (>= 1) with itself.
std::vector<int64_t> KeyframesAround(int64_t keyframe_id, const Map& map, int min_shared, int max_keyframes);

/// Landmarks to look for, by id.
struct LocalMap {
  std::vector<int64_t> points;
  std::vector<int64_t> lines;
};

/// What the best-connected keyframes of the associated landmarks see (PL-SLAM §V.A), without those already
/// associated. Where nothing is associated (the tracker was lost, or gives no ids): what `previous_id` (-1: none) and
/// those before it in its session see.
LocalMap LocalMapOf(const Association& association, int64_t previous_id, const Map& map, int max_keyframes);

/// Searches the landmarks among the features that show none yet, by projecting them with the pose, and adds what is
/// found.
void SearchByProjection(const Map& map, const LocalMap& local, const SE3& T_w_kf, const FeaturesView& features,
                        const StereoCamera& camera, const LocalisationOptions& options, Association& association);

/// Landmarks of a keyframe that should be in the image of a camera, and those of them that its features show. Lines
/// count twice.
struct ExpectedLandmarks {
  int expected = 0;
  int found = 0;
  /// Cells of a 4 x 4 grid over the image that should hold at least ten, and those in which a tenth of them is found.
  int cells = 0;
  int cells_shown = 0;

  double Share() const { return expected > 0 ? static_cast<double>(found) / expected : 0.0; }
};

/// Counts what a camera at `T_w_c` should see of a keyframe (which is of the map): landmarks that project into the
/// image, in front of the camera, and those among them that are associated.
ExpectedLandmarks CountExpected(const Map& map, int64_t keyframe_id, const SE3& T_w_c, const StereoCamera& camera,
                                const Association& association);

}  // namespace plslam
