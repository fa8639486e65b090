// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/map/map_update.h"
#include "viewer_headless/report/report_data.h"

namespace plslam {

/// Watches the map and keeps where its keyframes were before and after each correction that brought new loops, in
/// bounded memory: when there are more, the smallest corrections go.
class CorrectionLog {
 public:
  /// `map` is the map with `update` in it; `frame_id` the newest frame.
  void Add(const MapUpdate& update, const Map& map, int64_t frame_id);

  const std::vector<ReportCorrection>& corrections() const { return corrections_; }
  /// The move of the correction that came with this loop edge; 0 where nobody saw it.
  double Moved_m(const LoopEdge& edge) const;
  int64_t dropped() const { return dropped_; }

 private:
  void Compare(const Map& map, int64_t frame_id);
  void KeepLargest();
  void Follow(const MapUpdate& update);

  /// Keyframes as they were before the next update.
  std::map<int64_t, Eigen::Vector3d> positions_;
  std::map<std::pair<int64_t, int64_t>, double> moved_m_;
  std::vector<ReportCorrection> corrections_;
  int64_t dropped_ = 0;
};

}  // namespace plslam
