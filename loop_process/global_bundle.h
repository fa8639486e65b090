// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/landmark_types.h"
#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "core/optim/bundle/bundle.h"
#include "loop_process/options.h"

namespace plslam::loop {

/// A global bundle adjustment problem of a map, independent of map and features. `bundle.poses` and `keyframes` have
/// the same indices.
struct GlobalBundleProblem {
  /// Copied from the loop that it follows.
  KeyframeName keyframe;
  int64_t t_ns = 0;
  std::optional<MapVersion> map_version;
  std::vector<NamedKeyframe> keyframes;
  BundleProblem bundle;
};

/// Returns the problem of all keyframes whose features are stored, the first fixed, and of a number of landmarks for
/// each keyframe: those seen by most keyframes.
GlobalBundleProblem MakeGlobalBundleProblem(const Map& map, const KeyframeFeatures& features,
                                            const StereoCamera& camera, const GlobalBundleOptions& options);

/// Progress of adjustments that later loops ended: the displacement of each keyframe, in its own frame. The next
/// adjustment starts there, so that a map with a loop every minute converges, too.
class AdjustmentProgress {
 public:
  /// Applies the displacements to the keyframes of a problem made from the current map; each landmark moves with its
  /// first observing keyframe. Does nothing if the progress belongs to the map of another mapping_process.
  void Apply(GlobalBundleProblem& problem) const;

  /// Adds the displacements between a problem, to which `Apply` was applied, and its poses after adjustment.
  void Add(const GlobalBundleProblem& problem, const std::vector<CorrectedPose>& poses);

 private:
  SourceId numbering_;
  std::map<KeyframeId, SE3> T_before_now_;
};

/// Runs the global bundle adjustment (it follows PL-SLAM §VI.B, which stops at the pose graph). Returns kAdjustment
/// with poses, or without any on failure; `failure` then receives the reason. Slow; `stop` ends it early with the
/// poses reached so far.
LoopClosure AdjustGlobally(const GlobalBundleProblem& problem, const GlobalBundleOptions& options,
                           const std::atomic<bool>* stop, std::string* failure = nullptr);

}  // namespace plslam::loop
