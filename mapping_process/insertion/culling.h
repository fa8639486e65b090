// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/landmark_types.h"
#include "mapping_process/insertion/landmark_creation.h"
#include "mapping_process/insertion/visits.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Landmarks under recent-landmark culling: created a few keyframes of their session ago (PL-SLAM §V.B). Keyframes of
/// other sessions do not count, because they may be elsewhere.
class RecentLandmarks {
 public:
  /// Adds landmarks created with the next keyframe of the session.
  void Begin(const NewLandmarks& landmarks, SessionId session);

  /// Finishes the checks that are due: removes landmarks seen by too few keyframes. All checks of a session that `visits`
  /// has forgotten are due, because it has ended.
  void Cull(const CullingOptions& options, const Visits& visits, Map& map);

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.sessions_);
  }

 private:
  struct Session {
    int64_t begun = 0;  ///< number of checks begun, one with each keyframe
    std::map<int64_t, NewLandmarks> by_keyframe;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.begun, self.by_keyframe);
    }
  };
  std::map<SessionId, Session> sessions_;
};

/// Removes a keyframe and its features, connects its successor in the session with its predecessor, and passes on its
/// loops (`LoopsPassedOn`).
void TakeOut(KeyframeId keyframe_id, KeyframeFeatures& features, Map& map);

/// Removes redundant keyframes among `candidates` and returns their ids. A keyframe is redundant if a share of
/// `redundant_share` of its landmarks is seen by at least `redundant_observations` others. The first keyframe of the
/// map and of a session is never redundant, nor is the end of a loop. Keyframes are removed one by one, so each check
/// counts the remaining ones only.
std::vector<KeyframeId> RemoveRedundantKeyframes(const std::vector<KeyframeId>& candidates,
                                                 const CullingOptions& options, KeyframeFeatures& features, Map& map);

}  // namespace plslam::mapping
