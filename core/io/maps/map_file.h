// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/keyframe_features.h"
#include "core/map/map.h"

namespace plslam {

/// The newest keyframe of a session that is in the map: its number there and as the session counts.
struct StoredSession {
  KeyframeId keyframe_id = -1;  ///< -1: it has been forgotten
  int64_t session_keyframe_id = -1;

  bool operator==(const StoredSession&) const = default;
};

/// A map with everything that is needed to continue it.
struct StoredMap {
  /// Encoded camera with which the map was made; opaque here, its users compare it.
  std::vector<uint8_t> rig;
  Map map;
  /// Features of the map's keyframes, by keyframe id. They include every observation.
  KeyframeFeatures features;
  /// Greater than all ids that were ever assigned.
  KeyframeId next_keyframe_id = 0;
  LandmarkId next_point_id = 0;
  LandmarkId next_line_id = 0;
  std::map<SessionId, StoredSession> sessions;
  SessionId newest_session;
  int64_t newest_t_ns = 0;
  int64_t version = 0;
};

/// A map file: magic, format version, length, BLAKE2b checksum, then all values, little endian and to the last bit, so
/// that a decoded map is encoded to the same bytes again (covariances of landmarks, which a map stores in single
/// precision, are rounded once). See docs/map_files.md.
///
/// Throws std::runtime_error if the map violates a condition of decoding.
std::vector<uint8_t> EncodeMap(const StoredMap& stored);

/// The map has no pending changes. Throws std::runtime_error, in one sentence, for bytes that are no map file, of a
/// newer format, truncated, damaged, or with invalid values (not finite, rotations that are not unit, ids that do not
/// ascend, observations of features that a keyframe does not have). Memory is proportional to the number of bytes.
StoredMap DecodeMap(std::span<const uint8_t> bytes);

/// Writes a file beside it and renames that. Throws std::runtime_error, which names the file, if it cannot be written
/// or the map has no keyframe: an existing file is then kept.
void WriteMapFile(const std::string& path, const StoredMap& stored);

/// Errors name the file.
StoredMap ReadMapFile(const std::string& path);

}  // namespace plslam
