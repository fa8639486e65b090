// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace plslam::test {

/// Returns the bytes of a map file of one session, for comparing maps of two runs: without its random name, and without
/// the version, which counts published updates. After a kill more of them can be published, depending on what others
/// send again. Fails the test if it has several sessions; throws std::runtime_error if the file is no map.
std::vector<uint8_t> BytesWithoutName(const std::filesystem::path& file);

/// Describes in which parts two maps with other bytes differ: the next ids of both, and the number of differing
/// keyframes, points and lines; empty if they are equal.
std::string DifferenceOf(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b);

}  // namespace plslam::test
