// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/node/loop_report.h"

#include "core/errors/log.h"

namespace plslam::loop {

void LoopReport::CountLoop() { process_.SetCounter("loops", static_cast<double>(++n_loops_)); }

void LoopReport::CountAnswer(bool found) {
  process_.SetCounter("relocalisation.asked", static_cast<double>(++n_answers_));
  if (found) process_.SetCounter("relocalisation.found", static_cast<double>(++n_found_));
}

void LoopReport::CountFailedAdjustment(const std::string& failure) {
  const int64_t n = ++n_failed_;
  process_.SetCounter("adjustments.failed", static_cast<double>(n));
  if (n == 1) LogWarning("a global bundle adjustment failed (later ones are counted only): {}", failure);
}

}  // namespace plslam::loop
