// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "viewer_headless/report/correction_log.h"
#include "viewer_headless/report/picture_store.h"

namespace plslam {

/// What loop_process said about loops.
class LoopLog {
 public:
  void Add(const LoopClosure& closure);

  /// Loops of this run; those that the map came with are none. One that is said again counts once.
  int64_t closed() const { return static_cast<int64_t>(closed_.size()); }

  /// One row for each loop of the map, in that order; the newest 2000, and pictures of the newest 80.
  std::vector<ReportLoop> Loops(const Map& map, const CorrectionLog& corrections, const PictureStore& pictures) const;

 private:
  struct Figures {
    double score = 0.0;
    double detect_ms = 0.0;
    double correct_ms = 0.0;
  };

  std::map<std::pair<int64_t, int64_t>, Figures> figures_;  // by the keyframes of the edge
  std::set<std::pair<int64_t, int64_t>> closed_;            // session, and keyframe there
};

/// Loops whose pictures are shown at most.
inline constexpr size_t kMaxLoopPictures = 80;

}  // namespace plslam
