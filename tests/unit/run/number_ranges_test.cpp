// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/number_ranges.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

namespace plslam {
namespace {

TEST(NumberRanges, RoundTrip) {
  const std::vector<int64_t> numbers = {0, 3, 4, 5, 57, 60, 61};
  EXPECT_EQ(NumberRanges(numbers), "0 3-5 57 60-61");
  EXPECT_EQ(NumbersInRanges(NumberRanges(numbers)), std::set<int64_t>(numbers.begin(), numbers.end()));
  EXPECT_EQ(NumberRanges({}), "");
}

TEST(NumberRanges, TextIsLimited) {
  std::vector<int64_t> numbers;
  for (int64_t n = 0; n < 1000; n += 2) numbers.push_back(n);
  const std::string text = NumberRanges(numbers, 100);
  EXPECT_LE(text.size(), 100U);
  EXPECT_GT(NumbersInRanges(text).size(), 20U);
}

TEST(NumberRanges, OtherWordsAreIgnored) {
  EXPECT_EQ(NumbersInRanges("x 3- -4 5-a 7 9-8 1-2"), (std::set<int64_t>{1, 2, 7}));
  EXPECT_LE(NumbersInRanges("0-9223372036854775806").size(), 1'000'000U);
}

}  // namespace
}  // namespace plslam
