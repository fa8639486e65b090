// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/map/map.h"
#include "mapping_process/insertion/landmark_creation.h"

namespace plslam::mapping {

/// Ids that a map has assigned so far, and its version.
struct AssignedIds {
  KeyframeId next_keyframe = 0;
  LandmarkIds next_landmark;
  MapVersion version;
  /// The version in which the map last applied a loop or joined two parts.
  int64_t structural_version = 0;
};

/// Returns in one sentence why a correction cannot be applied to this map; empty if it can. Accepts ids of what was
/// removed since. Rejects ids that were never assigned, invalid poses, a correction none of whose keyframes is left,
/// one of another map, and one computed before the last structural correction, which it would undo.
std::string WhyNotOfMap(const LoopClosure& closure, const AssignedIds& given, const Map& map);

/// Whether a correction was computed with the ids of this map.
enum class MapIds {
  kPerhapsSame,  ///< unknown: compare the names of the keyframes
  kOthers,       ///< landmark ids differ, whatever the names of the keyframes are
};

/// Re-expresses a correction in the ids of this map. It may have been computed on the map of a mapping_process that
/// has exited; a restarted one, which receives the same keyframes again, may number them in another order. Keyframes
/// are identified by session and number within it. If no id differs, the correction is returned unchanged, including
/// culled keyframes, whose ids are not assigned again.
///
/// If a keyframe id differs, or landmark ids do, edges and poses of keyframes that are unnamed or not in the map are
/// dropped; so are all pairs of landmarks, because landmarks have no names: guided matching by projection finds these
/// pairs instead.
LoopClosure InIdsOf(const Map& map, const LoopClosure& closure, MapIds map_ids = MapIds::kPerhapsSame);

}  // namespace plslam::mapping
