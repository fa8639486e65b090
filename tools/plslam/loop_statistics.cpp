// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/loop_statistics.h"

namespace plslam {

void LoopStatistics::Add(LoopClosure::Kind kind, double detect_ms, double correct_ms) {
  if (kind == LoopClosure::Kind::kAdjustment) return adjust_ms_.Add(correct_ms);
  if (kind == LoopClosure::Kind::kLoop) return correct_ms_.Add(correct_ms);
  detect_ms_.Add(detect_ms);
}

void LoopStatistics::AddAnswer(bool found) {
  ++asked_;
  if (found) ++found_;
}

}  // namespace plslam
