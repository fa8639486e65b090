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

}  // namespace
}  // namespace plslam
