// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "core/map/map_update.h"
#include "viewer_headless/report/picture_store.h"
#include "viewer_headless/report/report_data.h"

namespace plslam::viewer {

/// Watches the map and keeps where its keyframes were before and after each correction that brought new loops, in
/// bounded memory: when there are more, the smallest corrections go.
class CorrectionLog {
 public:
  /// `map` is the map with `update` in it; `frame_id` the newest frame.
  void Add(const MapUpdate& update, const Map& map, FrameId frame_id);

  const std::vector<ReportCorrection>& corrections() const { return corrections_; }
  /// Returns the largest move of the correction that came with this loop edge; 0 if it was not observed.
  double Moved_m(const LoopEdge& edge) const;
  int64_t dropped() const { return dropped_; }

 private:
  void Compare(const Map& map, FrameId frame_id);
  void KeepLargest();
  void Follow(const MapUpdate& update);

  /// Keyframes as they were before the next update.
  std::map<KeyframeId, Eigen::Vector3d> positions_;
  std::map<std::pair<KeyframeId, KeyframeId>, double> moved_m_;
  std::vector<ReportCorrection> corrections_;
  int64_t dropped_ = 0;
};

/// The loops that loop_process has published.
class LoopLog {
 public:
  void Add(const LoopClosure& closure);

  /// Returns the number of loops of this run, without those of a loaded map. A republished loop is counted once.
  int64_t closed() const { return static_cast<int64_t>(closed_.size()); }

  /// One row for each loop of the map, in that order; the newest 2000, and pictures of the newest 80.
  std::vector<ReportLoop> Loops(const Map& map, const CorrectionLog& corrections, const PictureStore& pictures) const;

 private:
  struct Figures {
    double score = 0.0;
    double detect_ms = 0.0;
    double correct_ms = 0.0;
  };

  std::map<std::pair<KeyframeId, KeyframeId>, Figures> figures_;  // by the keyframes of the edge
  std::set<KeyframeName> closed_;
};

/// Largest number of loops with pictures.
inline constexpr size_t kMaxLoopPictures = 80;

}  // namespace plslam::viewer
