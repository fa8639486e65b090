// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/ids/map_version.h"
#include "core/map/keyframe.h"
#include "core/map/landmarks.h"
#include "core/map/map_update.h"

namespace plslam {
class loop_edge_t;
class map_adjustment_t;
class map_id_t;
class map_keyframe_t;
class map_line_t;
class map_point_t;
class map_totals_t;
class map_version_t;
class moved_keyframe_t;
}  // namespace plslam

namespace plslam::bus {

// Conversion of the parts of a map to messages and back, checked as in convert.h. Positions and poses keep all their
// bits, covariances of landmarks are rounded to single precision; a second conversion changes no bit, so that a copy of
// a map and the map have the same messages, byte for byte.

map_id_t ToMessage(const MapId& map);
std::optional<MapId> FromMessage(const map_id_t& message);

map_version_t ToMessage(const std::optional<MapVersion>& version);
/// Returns false if the message is invalid. `version` becomes nullopt if it has none.
bool FromMessage(const map_version_t& message, std::optional<MapVersion>& version);

map_keyframe_t ToMessage(const MapKeyframe& keyframe);
std::optional<MapKeyframe> FromMessage(const map_keyframe_t& message);

moved_keyframe_t ToMessage(const MovedKeyframe& keyframe);
std::optional<MovedKeyframe> FromMessage(const moved_keyframe_t& message);

map_point_t ToMessage(const MapPoint& point);
std::optional<MapPoint> FromMessage(const map_point_t& message);

map_line_t ToMessage(const MapLine& line);
std::optional<MapLine> FromMessage(const map_line_t& message);

map_totals_t ToMessage(const MapTotals& totals);
std::optional<MapTotals> FromMessage(const map_totals_t& message);

map_adjustment_t ToMessage(const AdjustmentFigures& figures);
std::optional<AdjustmentFigures> FromMessage(const map_adjustment_t& message);

loop_edge_t ToMessage(const LoopEdge& loop);
std::optional<LoopEdge> FromMessage(const loop_edge_t& message);

}  // namespace plslam::bus
