// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/map/map_update.h"
#include "viewer_headless/report/table.h"

namespace plslam::viewer {

/// Stage times of mapping_process by update of the map, in bounded memory: beyond 4000 rows every second one is
/// dropped.
class MapTimes {
 public:
  void Add(const MapUpdate& update, FrameId frame_id);

  const std::vector<std::string>& stage_names() const { return stage_names_; }
  /// `frame`: newest frame at that time; `stages_ms`, as wide as there are names, NaN for missing ones; `before_px`,
  /// `after_px`: reprojection error of the adjustment.
  Table Times() const;

 private:
  struct Row {
    int32_t frame = -1;
    std::vector<float> stages_ms;
    float before_px = 0.0F;
    float after_px = 0.0F;
  };

  std::vector<std::string> stage_names_;
  std::vector<Row> rows_;
  int64_t every_ = 1;
  int64_t heard_ = 0;
};

}  // namespace plslam::viewer
