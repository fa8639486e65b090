// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/nearest_key.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace plslam {
namespace {

/// The definition, straight down.
int SlowEditDistance(std::string_view a, std::string_view b) {
  if (a.empty() || b.empty()) return static_cast<int>(a.size() + b.size());
  const auto a1 = a.substr(1), b1 = b.substr(1);
  int best = SlowEditDistance(a1, b1) + (a[0] == b[0] ? 0 : 1);
  best = std::min({best, SlowEditDistance(a1, b) + 1, SlowEditDistance(a, b1) + 1});
  if (a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0]) {
    best = std::min(best, SlowEditDistance(a.substr(2), b.substr(2)) + 1);
  }
  return best;
}

TEST(EditDistance, AgreesWithTheDefinition) {
  const std::vector<std::string> words = {"", "a", "ab", "ba", "abc", "acb", "scale", "sclae", "slack", "cells"};
  for (const auto& a : words) {
    for (const auto& b : words) EXPECT_EQ(EditDistance(a, b), SlowEditDistance(a, b)) << a << " " << b;
  }
}

TEST(NearestKey, FirstOfEqualsAndNothing) {
  EXPECT_EQ(NearestKey("max_pionts", {"min_points", "max_points", "max_lines"}), "max_points");
  EXPECT_EQ(NearestKey("x", {"a", "b"}), "a");
  EXPECT_EQ(NearestKey("x", {}), "");
}

TEST(NearestKey, DottedKeysAreComparedPartByPart) {
  const std::vector<std::string> known = {"vo.map.local_keyframes",
                                          "vo.features.orb.max_points",
                                          "vo.features.orb.levels",
                                          "vo.features.lines.min_length_px",
                                          "vo.odometry.keyframes.max_frames",
                                          "vo.relocalisation.enabled",
                                          "vo.state_file"};
  struct Row {
    const char* written;
    const char* meant;
  };
  for (const Row& row :
       {Row{"vo.featurs", "vo.features"}, Row{"vo.feature.orb", "vo.features.orb"},
        Row{"vo.featurs.orb.max_points", "vo.features.orb.max_points"},
        Row{"vo.features.orb.max_pionts", "vo.features.orb.max_points"},
        Row{"vo.features.orb.maxpoints", "vo.features.orb.max_points"},
        Row{"vo.orb.max_points", "vo.features.orb.max_points"}, Row{"vo.max_points", "vo.features.orb.max_points"},
        Row{"vo.features.max_points", "vo.features.orb.max_points"},
        Row{"vo.features.lines.length_px", "vo.features.lines.min_length_px"},
        Row{"vo.map.local_keyframe", "vo.map.local_keyframes"},
        Row{"vo.maps.local_keyframes", "vo.map.local_keyframes"},
        Row{"vo.relocalization.enabled", "vo.relocalisation.enabled"}, Row{"vo.statefile", "vo.state_file"},
        Row{"vo.odometry.max_frames", "vo.odometry.keyframes.max_frames"}}) {
    EXPECT_EQ(NearestKey(row.written, known), row.meant) << row.written;
  }
}

}  // namespace
}  // namespace plslam
