// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/io/maps/map_file.h"

namespace plslam::test {

/// A map that much has happened to, with random features, sessions and a rig. Everything follows from the seed.
StoredMap RandomStoredMap(uint64_t seed, int steps);

/// The same, where another camera has seen every other keyframe.
StoredMap OfTwoCameras(uint64_t seed, int steps);

/// A map as mapping leaves it after a long run: each keyframe has `points` and `lines`, of which six in ten are seen
/// by six keyframes in a row.
StoredMap LongStoredMap(int keyframes, int points, int lines);

/// Puts the checksum right after a change of the bytes of a map file.
void Sign(std::vector<uint8_t>& bytes);

}  // namespace plslam::test
