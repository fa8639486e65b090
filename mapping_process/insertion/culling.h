// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/map/landmark_types.h"
#include "mapping_process/insertion/landmark_creation.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Recent landmarks: those younger than some keyframes of their session (PL-SLAM §V.B). Keyframes of other sessions,
/// which may be elsewhere, say nothing about them.
class RecentLandmarks {
 public:
  /// Landmarks that came with the next keyframe of the session.
  void Begin(const NewLandmarks& landmarks, int64_t session);

  /// Ends the checks that are due: landmarks that too few keyframes have seen go.
  void Cull(const CullingOptions& options, Map& map);

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.sessions_);
  }

 private:
  struct Session {
    int64_t begun = 0;  ///< checks: one with each keyframe
    std::map<int64_t, NewLandmarks> by_keyframe;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.begun, self.by_keyframe);
    }
  };
  std::map<int64_t, Session> sessions_;
};

/// A keyframe goes with its features, and the one after it in its session is tied to the one before it.
void TakeOut(int64_t keyframe_id, KeyframeFeatures& features, Map& map);

/// Of `candidates` those whose landmarks others see as well: each at least `redundant_observations` others, for a
/// share of `redundant_share`. The first keyframe of the map and of a session is never redundant, nor is the end of a
/// loop. One after the other is taken out, so that what is left is judged by what is left.
std::vector<int64_t> RemoveRedundantKeyframes(const std::vector<int64_t>& candidates, const CullingOptions& options,
                                              KeyframeFeatures& features, Map& map);

}  // namespace plslam::mapping
