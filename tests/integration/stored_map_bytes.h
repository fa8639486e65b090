// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace plslam::test {

/// Returns the bytes of a map file of one session without its random name, for comparing maps of two runs. Fails the
/// test if it has several sessions; throws std::runtime_error if the file is no map.
std::vector<uint8_t> BytesWithoutName(const std::filesystem::path& file);

}  // namespace plslam::test
