#pragma once

#include <cstdint>
#include <string>

#include "core/map/map.h"
#include "mapping_process/insertion/landmark_creation.h"

namespace plslam {

/// The names that a map has given so far, and its version.
struct GivenNames {
  int64_t next_keyframe = 0;
  LandmarkIds next_landmark;
  int64_t version = 0;
  /// The first one that has the last loop in it, or what brought two parts together.
  int64_t bent_version = 0;
};

/// Why a correction cannot be one of this map, in a sentence; empty where it can. Names of what has been removed since are
/// no fault, names that were never given are; so are poses that are none, a correction of which nothing is left, and one of
/// the map as it was before a loop or before two parts came together, which it would undo. A version of 0 says nothing: of another map.
std::string WhyNotOfMap(const LoopClosure& closure, const GivenNames& given, const Map& map);

}  // namespace plslam
