// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/map/map_update.h"
#include "tools/plslam/stage_times.h"

namespace plslam {

/// Counts the updates of the map by their heads; content is not looked at.
class MapStatistics {
 public:
  /// A version that has been counted changes nothing: the whole map may come again.
  void Add(const MapUpdate& head);

  /// 0: there is no map.
  int64_t version() const { return version_; }
  /// Of the newest version.
  const MapTotals& totals() const { return totals_; }
  const CommittedKeyframes& committed() const { return committed_; }

  /// Keyframes that see a landmark, on average; 0 without landmarks.
  double ObservationsPerPoint() const;
  double ObservationsPerLine() const;

  /// By stage, ms; of all updates, also those of a process that was killed.
  const std::map<std::string, QuantileSketch>& stage_ms() const { return stage_ms_.by_name(); }
  /// Means over the adjustments that had points, of their root mean squares; nothing where there was none.
  std::optional<double> ReprojectionBefore_px() const { return Mean(before_px_); }
  std::optional<double> ReprojectionAfter_px() const { return Mean(after_px_); }

 private:
  std::optional<double> Mean(double sum) const {
    return n_adjustments_ > 0 ? std::optional(sum / static_cast<double>(n_adjustments_)) : std::nullopt;
  }

  int64_t source_ = 0;
  int64_t version_ = 0;
  CommittedKeyframes committed_;
  MapTotals totals_;
  StageTimes stage_ms_;
  int64_t n_adjustments_ = 0;
  double before_px_ = 0.0;
  double after_px_ = 0.0;
};

}  // namespace plslam
