// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
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

/// The same state gives the same bytes.
std::vector<uint8_t> EncodeState(const MapperState& state);
/// The last state that the bytes, of a `StateFile`, have in full: what was being written in a crash, or comes behind
/// damage, counts for nothing, as does what is said of landmarks that the map does not have. Throws
/// std::runtime_error, in a sentence, where there is none.
MapperState DecodeState(std::span<const uint8_t> bytes);
/// Errors name the file.
MapperState ReadStateFile(const std::string& path);

/// A file with the newest state of a mapper, for programs of this version only: sealed records
/// (core/io/files/sealed_file.h), one behind the other. Features of a keyframe are written once. What then follows is
/// the map, or what has changed in it since the record before. When half of the file is out of date it is written anew
/// and takes the place of the old one. So a map that grows costs bytes in proportion to its size, and a loop, which
/// moves all of it, those of the map without features.
class StateFile {
 public:
  explicit StateFile(std::string path) : path_(std::move(path)) {}

  /// Of the mapper's next state, since the one before.
  void Note(const MapUpdate& update);
  /// The mapper is another one from now on.
  void BeginAnew();

  /// Throws std::runtime_error, which names the file, where it cannot be written; the next one is then written whole.
  void Write(const MapperState& state);

 private:
  void ForgetNotes();
  void WriteWhole(const MapperState& state);
  void Append(const MapperState& state);

  std::string path_;
  /// What was written last is in the file, and what has changed since is noted.
  bool is_whole_ = false;
  /// A correction has moved so much that the map is written again.
  bool has_moved_ = false;
  /// Ids, as often as they have changed; those that are gone by now, too.
  std::vector<int64_t> keyframes_, points_, lines_;
  size_t n_loops_ = 0;            ///< in the file
  int64_t newest_features_ = -1;  ///< in the file
  uint64_t length_ = 0;           ///< of the file
  uint64_t map_length_ = 0;       ///< of the map without features, when it was last written
};

}  // namespace plslam::mapping
