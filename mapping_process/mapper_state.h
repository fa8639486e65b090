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
#include "mapping_process/insertion/inertial_links.h"
#include "mapping_process/insertion/missed_landmarks.h"
#include "mapping_process/insertion/tracker_landmarks.h"

namespace plslam::mapping {

/// The complete state of a `Mapper` as of its last update: a mapper made of it continues bit for bit. A saved map omits
/// what concerns running sessions (recent landmarks, associations of the tracker's landmarks, paths), and counts of
/// missed landmarks, which begin again.
struct MapperState {
  StoredMap stored;
  RecentLandmarks recent_landmarks;
  MissedLandmarks missed_landmarks;
  Visits visits;
  InertialLinks inertial_links;
  TrackerLandmarks tracker;
  AdjustmentFigures figures;
  uint8_t committed = 0;  ///< 1: the newest keyframe is committed
  /// Corrections computed before this version are refused (`WhyNotOfMap`).
  int64_t structural_version = 0;
  uint8_t localise_only = 0;  ///< 1: localisation-only mode
  MapId map_id;
  /// The newest keyframe, if it is not committed: 1: of a lockstep session; kinds of closures taken about it, as bits.
  uint8_t lockstep = 0;
  uint8_t closures = 0;
  LoopAnswer answer;  ///< the published one
};

/// Returns the state as bytes; equal states give equal bytes.
std::vector<uint8_t> EncodeState(const MapperState& state);
/// Reads the last complete state from the bytes of a `StateFile`. Ignores a record that a crash cut off, records after
/// a damaged one, and associations with landmarks that are not in the map. Throws std::runtime_error with one sentence
/// if there is no complete state.
MapperState DecodeState(std::span<const uint8_t> bytes);
/// As `DecodeState`; errors name the file.
MapperState ReadStateFile(const std::string& path);

/// A file with the newest state of a mapper, for programs of this version only: a sequence of sealed records
/// (core/files/sealed_file.h). Features of a keyframe are written once; the map follows, then its changes since the
/// previous record. When half of the file is obsolete, a new file replaces it. A growing map thus costs bytes in
/// proportion to its size, and a loop, which moves all of it, the size of the map without features.
class StateFile {
 public:
  explicit StateFile(std::string path) : path_(std::move(path)) {}

  /// Records the changes of the mapper's next state.
  void Note(const MapUpdate& update);
  /// The next state is that of another mapper.
  void Reset();

  /// Throws std::runtime_error, which names the file, if writing fails; the next state is then written completely.
  void Write(const MapperState& state);

 private:
  void ForgetNotes();
  void WriteWhole(const MapperState& state);
  void Append(const MapperState& state);

  std::string path_;
  /// Whether the last written state is in the file, and all changes since are recorded.
  bool is_whole_ = false;
  /// Whether a correction moved the map, which is then written completely.
  bool has_moved_ = false;
  /// Changed ids, possibly repeated, including removed ones.
  std::vector<KeyframeId> keyframes_;
  std::vector<LandmarkId> points_, lines_;
  /// Added loops, including those removed since.
  std::vector<LoopEdge> loops_;
  KeyframeId newest_features_ = -1;  ///< newest keyframe with features in the file
  uint64_t length_ = 0;              ///< of the file, in bytes
  uint64_t map_length_ = 0;          ///< of the last complete map without features, in bytes
};

}  // namespace plslam::mapping
