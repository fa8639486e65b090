// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>

#include "core/ids/ids.h"
#include "core/io/maps/map_file.h"

namespace plslam::map_file {

// Checks of the values of a map file. Each throws std::runtime_error that names the culprit.

void Check(const MapKeyframe& keyframe);
void Check(KeyframeId keyframe_id, const FeaturesView& features);
/// An image has valid pixels and belongs to a keyframe with features.
void Check(KeyframeId keyframe_id, const TakenImage& image, const KeyframeFeatures& features);
void Check(KeyframeId keyframe_id, const UpDirection& up, const Map& map);
/// Observations ascend and refer to existing features.
void Check(const MapPoint& point, const KeyframeFeatures& features);
void Check(const MapLine& line, const KeyframeFeatures& features);
void Check(const LoopEdge& loop);
/// Each feature belongs to one landmark: there are as many observations in the map as were put.
void CheckObservationsOnce(const Map& map, int64_t point_observations, int64_t line_observations);
/// Next numbers are greater than all that are in use, and sessions and features name keyframes of the map.
void CheckWhole(const StoredMap& stored);

}  // namespace plslam::map_file
