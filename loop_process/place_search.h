// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "core/localisation/local_map.h"
#include "core/localisation/pose_refinement.h"
#include "core/map/map.h"
#include "core/places/vocabulary.h"

namespace plslam::loop {

/// A camera found among the landmarks of a place, with the evidence. Lines count twice.
struct FoundPlace {
  KeyframePose pose;
  Association association;
  /// Features associated with a landmark after optimisation, and matches before it.
  int inliers = 0;
  int matches = 0;
  /// Landmarks of the old keyframe that are expected to be visible, and those found.
  ExpectedLandmarks landmarks;
  /// Cells of a 4 x 4 grid over the image that hold inliers.
  int cells = 0;
  /// Median depth of the inliers.
  double median_depth_m = 0.0;
};

/// A keyframe and the landmarks that it and its best neighbours see.
struct Place {
  KeyframeId keyframe_id = -1;
  LocalMap landmarks;
};

Place PlaceAround(const Map& map, KeyframeId keyframe_id, int max_keyframes);

/// Features of an image and the vocabulary nodes of its points.
struct DescribedImage {
  FeaturesView features;
  const FeatureNodes& point_nodes;
};

/// Estimates a pose without a prior from a keyframe that may show the same place (PL-SLAM §VI.A.2): matches features
/// by descriptor with those of the keyframe that observe a landmark (points within a vocabulary node, or all pairs if
/// there are few), then a pose from minimal sets and the robust estimator of §IV.C. Returns nullopt if fewer than
/// `min_matches` agree.
std::optional<KeyframePose> GuessPose(const Map& map, KeyframeId keyframe_id, const DescribedImage& keyframe,
                                      const DescribedImage& image, const StereoCamera& camera,
                                      const LocalisationOptions& options, int min_matches);

/// Finds a camera near `T_w_c` in a place: matches landmarks by projection and runs the robust estimator, twice.
std::optional<FoundPlace> FindPlace(const Map& map, const Place& place, const SE3& T_w_c,
                                    const FeaturesView& features, const StereoCamera& camera,
                                    const LocalisationOptions& options);

}  // namespace plslam::loop
