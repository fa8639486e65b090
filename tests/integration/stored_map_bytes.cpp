// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/stored_map_bytes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/io/maps/map_file.h"
#include "core/io/maps/map_file_fields.h"

namespace plslam::test {
namespace {

/// Number of elements that are in one only, or have other bytes.
template <class Elements>
size_t Differing(const Elements& a, const Elements& b) {
  size_t n = 0;
  for (const auto& [id, element] : a) {
    const auto* found = b.Find(id);
    n += found == nullptr || archive::ToBytes(element) != archive::ToBytes(*found) ? 1U : 0U;
  }
  for (const auto& [id, element] : b) n += a.Find(id) == nullptr ? 1U : 0U;
  return n;
}

}  // namespace

std::vector<uint8_t> BytesWithoutName(const std::filesystem::path& file) {
  StoredMap stored = ReadMapFile(file.string());
  EXPECT_EQ(stored.sessions.size(), 1U);
  if (stored.sessions.empty()) return {};
  stored.sessions = {{0, stored.sessions.begin()->second}};
  stored.newest_session = 0;
  stored.version = 0;
  std::vector<MapKeyframe> keyframes;
  for (const auto& [id, keyframe] : stored.map.keyframes()) keyframes.push_back(keyframe);
  for (MapKeyframe& keyframe : keyframes) {
    keyframe.name.session = 0;
    stored.map.Put(keyframe);
  }
  return EncodeMap(stored);
}

std::string DifferenceOf(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  if (a == b) return "";
  const StoredMap one = DecodeMap(a), other = DecodeMap(b);
  std::string text = fmt::format("next keyframe {} and {}, next point {} and {}, next line {} and {}",
                                 one.next_keyframe_id.value, other.next_keyframe_id.value, one.next_point_id.value,
                                 other.next_point_id.value, one.next_line_id.value, other.next_line_id.value);
  text +=
      fmt::format(", {} keyframes, {} points, {} lines differ", Differing(one.map.keyframes(), other.map.keyframes()),
                  Differing(one.map.points(), other.map.points()), Differing(one.map.lines(), other.map.lines()));
  if (archive::ToBytes(one.map.loops()) != archive::ToBytes(other.map.loops())) text += ", loops differ";
  if (one.newest_t_ns != other.newest_t_ns) text += ", newest times differ";
  if (one.sessions != other.sessions) text += ", sessions differ";
  return text;
}

}  // namespace plslam::test
