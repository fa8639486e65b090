// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/stored_map_bytes.h"

#include <gtest/gtest.h>

#include "core/io/maps/map_file.h"

namespace plslam::test {

std::vector<uint8_t> BytesWithoutName(const std::filesystem::path& file) {
  StoredMap stored = ReadMapFile(file.string());
  EXPECT_EQ(stored.sessions.size(), 1U);
  if (stored.sessions.empty()) return {};
  stored.sessions = {{0, stored.sessions.begin()->second}};
  stored.newest_session = 0;
  std::vector<MapKeyframe> keyframes;
  for (const auto& [id, keyframe] : stored.map.keyframes()) keyframes.push_back(keyframe);
  for (MapKeyframe& keyframe : keyframes) {
    keyframe.name.session = 0;
    stored.map.Put(keyframe);
  }
  return EncodeMap(stored);
}

}  // namespace plslam::test
