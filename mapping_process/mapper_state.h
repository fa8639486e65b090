// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/io/maps/map_file.h"
#include "core/map/map_update.h"
#include "mapping_process/insertion/culling.h"
#include "mapping_process/insertion/tracker_landmarks.h"

namespace plslam::mapping {

/// Everything that a `Mapper` knows as of its last update: one that is made of it goes on with the same bits. What a
/// saved map leaves out is of the running sessions only: recent landmarks, and which landmarks of the tracker became
/// which.
struct MapperState {
  StoredMap stored;
  RecentLandmarks recent_landmarks;
  TrackerLandmarks tracker;
  AdjustmentFigures figures;
  uint8_t committed = 0;  ///< 1: nothing more is to be said about the newest keyframe
  /// Adjustments of the map as it was before this version are refused (`WhyNotOfMap`).
  int64_t structural_version = 0;
  uint8_t localise_only = 0;  ///< 1: the map stays as it is
  int64_t began_version = 0;  ///< `MapUpdate::began_version`
};

/// The same state gives the same bytes. Throws std::runtime_error where its map breaks what `DecodeMap` demands.
std::vector<uint8_t> EncodeState(const MapperState& state);
/// Throws std::runtime_error, in a sentence, for bytes that are none. What is said of landmarks that the map does not
/// have counts for nothing.
MapperState DecodeState(std::span<const uint8_t> bytes);

/// A sealed file (core/io/files/sealed_file.h), for programs of this version only. Errors name the file.
void WriteStateFile(const std::string& path, const MapperState& state);
MapperState ReadStateFile(const std::string& path);

}  // namespace plslam::mapping
