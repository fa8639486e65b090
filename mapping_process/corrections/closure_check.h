// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/map/map.h"
#include "mapping_process/insertion/landmark_creation.h"

namespace plslam::mapping {

/// The names that a map has given so far, and its version.
struct GivenNames {
  int64_t next_keyframe = 0;
  LandmarkIds next_landmark;
  int64_t version = 0;
  /// The first one that has the last loop in it, or what brought two parts together.
  int64_t structural_version = 0;
};

/// Why a correction cannot be one of this map, in a sentence; empty where it can. Names of what has been removed
/// since are no fault, names that were never given are; so are poses that are none, a correction of which nothing is
/// left, and one of the map as it was before a loop or before two parts came together, which it would undo. A version
/// of 0 says nothing: of another map.
std::string WhyNotOfMap(const LoopClosure& closure, const GivenNames& given, const Map& map);

/// What is known of the ids of the map that a correction was computed on.
enum class MapIds {
  kPerhapsSame,  ///< the names of the keyframes tell
  kOthers,       ///< those of landmarks are others, whatever the names tell
};

/// A correction in the ids of this map. It may have been computed on the map of a mapping_process that has died, and
/// the one in its place, which heard the same keyframes again, perhaps numbers them in another order: sessions and
/// numbers there tell which is which. Where none differs, the correction as it is: also with keyframes that were
/// culled since, whose ids are given to no other.
///
/// Where one differs, or landmarks do, edges and poses of keyframes that the map does not have, or that bear no name,
/// are left out; and, since landmarks bear no names, all pairs of them and the version: what they would have joined
/// is found by projection.
LoopClosure InIdsOf(const Map& map, const LoopClosure& closure, MapIds map_ids = MapIds::kPerhapsSame);

}  // namespace plslam::mapping
