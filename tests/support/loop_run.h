// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "loop_process/loop_closer.h"
#include "tests/support/slam_run.h"

namespace plslam::test {

/// Two keyframes whose relative pose loop_process measured, and its error.
struct LoopOfRun {
  KeyframeName keyframe;
  int64_t frame = -1;
  int64_t old_frame = -1;
  loop::LoopEvidence evidence;
  double score = 0.0;
  /// Against the truth; negative if there is none.
  double error_m = -1.0;
  double error_deg = -1.0;

  /// More than half a metre or 5 degrees off.
  bool IsFalse() const { return error_m > 0.5 || error_deg > 5.0; }
};

/// Revisits by the truth: runs of keyframes with an older keyframe near them that looks in the same direction and is
/// not just before them.
struct Revisits {
  int total = 0;
  /// With landmarks shared across, or a loop.
  int closed = 0;
  int keyframes = 0;
  int closed_keyframes = 0;
};

struct LoopRun {
  SlamRun slam;
  /// In order: the closed ones, and all verified candidates.
  std::vector<LoopOfRun> loops;
  std::vector<LoopOfRun> looked_at;
  /// Error of the trajectory before and after the correction and after the adjustment that followed, for each loop.
  std::vector<double> ate_before_m, ate_corrected_m, ate_adjusted_m;
  /// Work of this thread in ms: for each keyframe; for each loop (pose graph and the rest of `Check` in that case), the
  /// mapper's part, and the adjustments.
  std::vector<double> check_ms, loop_ms, correct_ms, adjust_ms;
  /// Corrections that the mapper rejected, with its reasons.
  std::vector<std::string> refused;
  Revisits revisits;
  /// Frames for which relocalisation was requested, those relocalised, and those relocalised at a wrong position; ms
  /// each.
  int asked = 0;
  int found = 0;
  int found_elsewhere = 0;
  std::vector<double> ask_ms;
};

struct LoopRunOptions {
  vo::VoOptions vo;
  mapping::MappingOptions mapping;
  loop::LoopOptions loops;
  int stride = 1;
  int max_frames = 1 << 30;
  /// After the last frame repeat all frames in reverse order.
  bool forth_and_back = false;
  /// Request relocalisation of every n-th frame; 0: none.
  int ask_every = 0;
};

/// Runs front end, odometry, mapping and loop closing over a dataset in this process, as in lockstep: a keyframe's loop
/// closure takes effect with the map of that keyframe.
LoopRun RunLoops(const Dataset& dataset, const PlaceRecogniser& places, const LoopRunOptions& options);

}  // namespace plslam::test
