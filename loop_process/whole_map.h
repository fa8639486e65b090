// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "core/map/landmark_types.h"
#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "core/optim/bundle/bundle.h"
#include "loop_process/options.h"

namespace plslam {

/// A map as an adjustment of all its keyframes: a value that needs neither map nor features any more. Places in
/// `bundle.poses` are those of `keyframes`.
struct WholeMapProblem {
  /// As in the messages about the loop that it follows.
  int64_t session = 0;
  int64_t session_keyframe_id = -1;
  int64_t t_ns = 0;
  int64_t map_source = 0;
  int64_t map_version = 0;
  std::vector<KeyframeName> keyframes;
  BundleProblem bundle;
};

/// All keyframes whose features are known, the first fixed, and of their landmarks those that most keyframes see, so
/// many for each keyframe.
WholeMapProblem MakeWholeMapProblem(const Map& map, const KeyframeFeatures& features, const StereoCamera& camera,
                                    const WholeMapOptions& options);

/// Bundle adjustment of the whole map (what follows PL-SLAM §VI.B, which stops at the pose graph). kind kAdjustment
/// with poses, or kAdjustment without any where it failed; `failure` says why. Slow; `stop` ends it early with what
/// it has.
LoopClosure AdjustWholeMap(const WholeMapProblem& problem, const WholeMapOptions& options,
                           const std::atomic<bool>* stop, std::string* failure = nullptr);

}  // namespace plslam
