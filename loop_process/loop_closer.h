// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/map/keyframe.h"
#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "core/places/place_recogniser.h"
#include "loop_process/global_bundle.h"
#include "loop_process/keyframe_memory.h"
#include "loop_process/loop_search.h"
#include "loop_process/options.h"

namespace plslam::loop {

/// Loop closing (PL-SLAM §VI): detects places that were seen before, verifies them, and computes the correction of
/// the map. No clock, no thread, no messages: the same calls give the same results.
///
/// Its only state are the features of the keyframes: a detection depends on them, the map and the newest keyframe
/// alone, so a restarted loop_process continues as the previous one would have.
class LoopCloser {
 public:
  LoopCloser(const StereoCamera& camera, PlaceRecogniser places, const LoopOptions& options);

  /// Adds the features of a keyframe, before or after the map inserts it. Returns false if they are already stored.
  bool AddKeyframe(const Keyframe& keyframe) { return memory_.Add(keyframe); }
  /// Called when another map replaces the current one: sessions that it does not contain have ended.
  void ForgetSessions() { memory_.ForgetSessions(); }
  bool Contains(const KeyframeName& keyframe) const { return memory_.Contains(keyframe); }

  /// Updates the index of places to the keyframes of the map. `Check` calls it; call it for a map that was loaded, or
  /// before `Relocalise` on a map without loops to check. `continues` as in `KeyframeMemory`.
  void Follow(const Map& map, bool continues = false) { memory_.Follow(map, continues); }

  bool MoveOldToFiles() { return memory_.MoveOldToFiles(); }

  /// Checks a keyframe for a loop, given the map right after it was inserted and adjusted. Returns kNone, or kLoop with
  /// the edge, the pairs of landmarks to merge and the corrected poses; `more` then requests a global bundle
  /// adjustment, except in a map that agrees with the edge and has removed a third of its keyframes. The caller fills
  /// in the version of the map and the times. Returns kNone also for a keyframe that is not in the map or whose
  /// features are missing.
  LoopClosure Check(const Map& map, const KeyframeName& name);

  /// Returns the global bundle adjustment problem of the map, to be called after the map has applied `loop`, whose
  /// session and keyframe it carries.
  GlobalBundleProblem MakeGlobalBundle(const Map& map, const LoopClosure& loop) const;

  /// Finds the pose of a frame without a prior. The caller fills in the request that it answers.
  Relocalisation Relocalise(const Map& map, const FeaturesView& features) const;

  const LoopOptions& options() const { return options_; }
  /// Candidates and evidence of the last `Check`, for reports and experiments.
  const LoopSearch& last_search() const { return last_; }

 private:
  StereoCamera camera_;
  LoopOptions options_;
  KeyframeMemory memory_;
  LoopSearch last_;
};

}  // namespace plslam::loop
