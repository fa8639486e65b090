// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/map/loop_closure.h"
#include "tools/plslam/quantile_sketch.h"

namespace plslam {

/// Counts what loop_process says in a run; how many loops the map has, with those it came with, is in `MapTotals`.
class LoopStatistics {
 public:
  void Add(LoopClosure::Kind kind, double detect_ms, double correct_ms);
  void AddAnswer(bool found);

  int64_t keyframes() const { return detect_ms_.count() + correct_ms_.count(); }
  int64_t loops() const { return correct_ms_.count(); }
  int64_t asked() const { return asked_; }
  int64_t found() const { return found_; }
  /// Of keyframes that closed no loop; of those that did, with the correction; of the adjustments of the whole map.
  const QuantileSketch& detect_ms() const { return detect_ms_; }
  const QuantileSketch& correct_ms() const { return correct_ms_; }
  const QuantileSketch& adjust_ms() const { return adjust_ms_; }

 private:
  QuantileSketch detect_ms_;
  QuantileSketch correct_ms_;
  QuantileSketch adjust_ms_;
  int64_t asked_ = 0;
  int64_t found_ = 0;
};

}  // namespace plslam
