#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/localisation/landmark_kinds.h"
#include "mapping_process/landmark_creation.h"
#include "mapping_process/options.h"

namespace plslam {

/// Landmarks on trial: those younger than some keyframes (PL-SLAM §V.B).
class Trial {
 public:
  /// Landmarks that came with the `inserted`-th keyframe.
  void Begin(const NewLandmarks& landmarks, int64_t inserted);

  /// Ends the trials that are due after the `inserted`-th keyframe: landmarks that too few keyframes have seen go.
  void Judge(int64_t inserted, const CullingOptions& options, Map& map);

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.by_keyframe_);
  }

 private:
  std::map<int64_t, NewLandmarks> by_keyframe_;
};

/// Of `candidates` those whose landmarks others see as well: each at least `redundant_sights` others, for a share of
/// `redundant_share`. The first keyframe of the map and of a session is never redundant. One after the other is taken out, so
/// that what is left is judged by what is left.
std::vector<int64_t> RemoveRedundantKeyframes(const std::vector<int64_t>& candidates, const CullingOptions& options,
                                              KeyframeFeatures& features, Map& map);

}  // namespace plslam
