#pragma once

#include "core/map/map.h"

namespace plslam {

/// What is known of the ids of the map that a correction was computed on.
enum class MapIds {
  kPerhapsSame,  ///< the names of the keyframes tell
  kOthers,       ///< those of landmarks are others, whatever the names tell
};

/// A correction in the ids of this map. It may have been computed on the map of a mapping_process that has died, and the
/// one in its place, which heard the same keyframes again, perhaps numbers them in another order: sessions and numbers
/// there tell which is which. Where none differs, the correction as it is: also with keyframes that were culled since, whose
/// ids are given to no other.
///
/// Where one differs, or landmarks do, edges and poses of keyframes that the map does not have, or that bear no name, are left out; and,
/// since landmarks bear no names, all pairs of them and the version: what they would have joined is found by projection.
LoopClosure InIdsOf(const Map& map, const LoopClosure& closure, MapIds map_ids = MapIds::kPerhapsSame);

}  // namespace plslam
