#pragma once

#include "core/localisation/landmark_kinds.h"

namespace plslam {

/// Names the landmark as the one that the feature of `sight` shows, unless its keyframe sees the landmark already or the
/// feature shows another; then false. Its descriptor is chosen anew (PL-SLAM §V.A: the most representative one).
template <class Kind>
bool AddSight(int64_t landmark_id, const Sight& sight, const KeyframeFeatures& features, Map& map);

/// Takes a sight away; the landmark goes with its last one.
template <class Kind>
void DropSight(int64_t landmark_id, int64_t keyframe_id, const KeyframeFeatures& features, Map& map);

/// Makes one landmark of two, under the smaller id. False, and nothing done, where a keyframe sees them apart.
template <class Kind>
bool Fuse(int64_t a, int64_t b, const KeyframeFeatures& features, Map& map);

}  // namespace plslam
