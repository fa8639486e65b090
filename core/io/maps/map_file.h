// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/map/keyframe_features.h"
#include "core/map/map.h"

namespace plslam {

/// The newest keyframe of a session that is in the map: its number there and as the session counts.
struct StoredSession {
  int64_t keyframe_id = -1;  ///< -1: it has been forgotten
  int64_t session_keyframe_id = -1;

  bool operator==(const StoredSession&) const = default;
};

/// A map with everything that is needed to go on in it.
struct StoredMap {
  /// The camera it was made with, encoded by whoever compares it; opaque here.
  std::vector<uint8_t> rig;
  Map map;
  /// Of the keyframes that the map has, by their number in it. Every observation is among them.
  KeyframeFeatures features;
  /// Greater than any that was ever given.
  int64_t next_keyframe_id = 0;
  int64_t next_point_id = 0;
  int64_t next_line_id = 0;
  std::map<int64_t, StoredSession> sessions;
  int64_t newest_session = 0;
  int64_t newest_t_ns = 0;
  int64_t version = 0;
};

/// A map file: magic, format version, length, BLAKE2b checksum, then all values, little endian and to the last bit,
/// so that what is decoded is encoded to the same bytes again (covariances of landmarks, which a map keeps in single
/// precision, are rounded once). See docs/map_files.md.
///
/// Throws std::runtime_error where the map breaks what decoding demands.
std::vector<uint8_t> EncodeMap(const StoredMap& stored);

/// The map has no changes to take. Throws std::runtime_error, in one sentence, for bytes that are no map file, of a
/// newer format, cut off, damaged, or whose values cannot be (not finite, rotations that are not unit, numbers that
/// do not ascend, observations of features that a keyframe does not have). Needs memory in proportion to the bytes.
StoredMap DecodeMap(std::span<const uint8_t> bytes);

/// Beside the file and renamed. Throws std::runtime_error, which names the file, where it cannot be written, and
/// where the map has no keyframe: a file that was there stays.
void WriteMapFile(const std::string& path, const StoredMap& stored);

/// Errors name the file.
StoredMap ReadMapFile(const std::string& path);

}  // namespace plslam
