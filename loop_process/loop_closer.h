// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/geometry/stereo_camera.h"
#include "core/map/keyframe.h"
#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "core/places/place_recogniser.h"
#include "loop_process/keyframe_memory.h"
#include "loop_process/loop_search.h"
#include "loop_process/options.h"
#include "loop_process/whole_map.h"

namespace plslam::loop {

/// Loop closing (PL-SLAM §VI): recognises places that were seen before, verifies them, and says how the map must
/// bend. No clock, no thread, no messages: the same calls give the same answers.
///
/// It remembers the features of the keyframes and nothing else: whether there is a loop follows from them, the map
/// and the newest keyframe alone, so a loop_process that starts anew goes on as the old one would have.
class LoopCloser {
 public:
  LoopCloser(const StereoCamera& camera, PlaceRecogniser places, const LoopOptions& options);

  /// Features of a keyframe, which may come before or after the map has it. False where they are known.
  bool AddKeyframe(const Keyframe& keyframe) { return memory_.Add(keyframe); }
  /// Another map has taken the place of the one before: sessions that it does not have are done with.
  void ForgetSessions() { memory_.ForgetSessions(); }
  bool Knows(int64_t session, int64_t keyframe_id) const { return memory_.Knows(session, keyframe_id); }

  /// Brings the index of places in step with the map: keyframes that it lost leave, those that it has come in.
  /// `Check` does it by itself; for a map that was loaded, or before `Relocalise` on a map without loops to check.
  void Follow(const Map& map) { memory_.Follow(map); }

  bool LeaveOldInFiles() { return memory_.LeaveOldInFiles(); }

  /// What to say of a keyframe, given the map right after it was inserted and adjusted: kNone, or kLoop with the
  /// edge, the landmarks that are the same and where the keyframes lie when it is closed; then `more` says whether an
  /// adjustment of the whole map should follow. The caller fills in the map's source and version and the times. A
  /// keyframe that is not in the map, or came without features, is kNone.
  LoopClosure Check(const Map& map, int64_t session, int64_t session_keyframe_id);

  /// The map as it is, to be adjusted as a whole: after the map has taken over a loop that asked for it by `more`.
  /// The session and keyframe are those of the loop.
  WholeMapProblem WholeMap(const Map& map, const LoopClosure& loop) const;

  /// Where a frame is of which nothing is known. The caller fills in whose request it is.
  Relocalisation Relocalise(const Map& map, const FeaturesView& features) const;

  const LoopOptions& options() const { return options_; }
  /// What the last `Check` looked at, for reports and experiments.
  const LoopSearch& last_search() const { return last_; }

 private:
  StereoCamera camera_;
  LoopOptions options_;
  KeyframeMemory memory_;
  LoopSearch last_;
};

}  // namespace plslam::loop
