// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/ids/ids.h"
#include "core/io/maps/map_file.h"
#include "tools/evaluate/drawing/drawing.h"

namespace plslam::evaluate {

/// Returns two keyframes for a picture: those of the last closed loop; if there is none, one in the middle of the map
/// and the neighbour farthest from it with 100 shared landmarks (or its best). Returns nullopt if no two keyframes
/// share a landmark.
std::optional<std::pair<KeyframeId, KeyframeId>> PairWorthShowing(const Map& map);

/// A keyframe of the figure: its rectified left image and its features.
struct PairedImage {
  std::string name;
  cv::Mat image;
  const FeaturesView* features = nullptr;
};

/// Features of two keyframes that show the same landmarks.
struct SameFeatures {
  std::vector<std::pair<int, int>> points;
  std::vector<std::pair<int, int>> lines;
};

SameFeatures SharedBy(const Map& map, KeyframeId a, KeyframeId b);

/// Draws both images with their features, one above the other if they are wide, else side by side. Features of the same
/// landmark have the same colour in both, by its position in the first; the others are small and grey. Some of them are
/// joined.
Drawing PairFigure(const std::string& title, const PairedImage& first, const PairedImage& second,
                   const SameFeatures& same);

}  // namespace plslam::evaluate
