// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "core/localisation/local_map.h"
#include "core/localisation/pose_refinement.h"
#include "core/map/map.h"
#include "core/places/vocabulary.h"

namespace plslam::loop {

/// A camera found among the landmarks of a place, and what speaks for it. Lines count twice.
struct FoundPlace {
  KeyframePose pose;
  Association association;
  /// Features that show a landmark, and matches they were chosen from.
  int inliers = 0;
  int matches = 0;
  /// Landmarks of the old keyframe itself.
  ExpectedLandmarks landmarks;
  /// Cells of a 4 x 4 grid over the image that hold inliers.
  int cells = 0;
  /// Of the inliers' distances.
  double median_depth_m = 0.0;
};

/// A keyframe and the landmarks that it and its best neighbours see.
struct Place {
  int64_t keyframe_id = -1;
  LocalMap landmarks;
};

Place PlaceAround(const Map& map, int64_t keyframe_id, int max_keyframes);

/// Features of an image and the nodes of its points in the vocabulary.
struct DescribedImage {
  FeaturesView features;
  const FeatureNodes& point_nodes;
};

/// Where a camera is of which nothing is known but that it may see what a keyframe saw (PL-SLAM §VI.A.2): features
/// matched by descriptor with those of the keyframe that show a landmark (points in the same node of the vocabulary,
/// or all where they are few), pose from minimal sets, robust estimator of §IV.C. nullopt where fewer than
/// `min_matches` agree.
std::optional<KeyframePose> GuessPose(const Map& map, int64_t keyframe_id, const DescribedImage& keyframe,
                                      const DescribedImage& image, const StereoCamera& camera,
                                      const LocalisationOptions& options, int min_matches);

/// Finds a camera near `T_w_c` in a place: landmarks searched by projection, robust estimator, twice.
std::optional<FoundPlace> FindPlace(const Map& map, const Place& place, const SE3& T_w_c,
                                    const FeaturesView& features, const StereoCamera& camera,
                                    const LocalisationOptions& options);

}  // namespace plslam::loop
