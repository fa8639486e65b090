// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/map/landmark_types.h"
#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "core/optim/bundle/bundle.h"
#include "loop_process/options.h"

namespace plslam::loop {

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

/// What adjustments had reached when loops that were found meanwhile ended them: by how much they have moved each
/// keyframe, in the keyframe's own frame. The adjustment that follows a loop begins there instead of from nothing, so
/// that a map with a loop a minute is adjusted to the end, too.
class AdjustmentProgress {
 public:
  /// Moves the keyframes of a problem that was made of the map as much, and landmarks with the first one that sees
  /// them. Nothing where what was reached is of the map of another mapping_process.
  void Apply(WholeMapProblem& problem) const;

  /// The adjustment of a problem, to which this was applied, has come to these poses.
  void Add(const WholeMapProblem& problem, const std::vector<CorrectedPose>& poses);

 private:
  int64_t map_source_ = 0;
  std::map<int64_t, SE3> T_before_now_;
};

/// Bundle adjustment of the whole map (what follows PL-SLAM §VI.B, which stops at the pose graph). kind kAdjustment
/// with poses, or kAdjustment without any where it failed; `failure` says why. Slow; `stop` ends it early with what
/// it has.
LoopClosure AdjustWholeMap(const WholeMapProblem& problem, const WholeMapOptions& options,
                           const std::atomic<bool>* stop, std::string* failure = nullptr);

}  // namespace plslam::loop
