// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/id_map.h"

#include <gmock/gmock.h>

#include <limits>
#include <map>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/ids/ids.h"

namespace plslam {
namespace {

using testing::ElementsAre;

using Texts = IdMap<KeyframeId, std::string>;
using Plain = std::map<KeyframeId, std::string>;

std::vector<KeyframeId> IdsOf(const Texts& values) {
  std::vector<KeyframeId> ids;
  for (const auto& [id, value] : values) ids.push_back(id);
  return ids;
}

void ExpectSame(const Texts& values, const Plain& plain) {
  EXPECT_EQ(Plain(values.begin(), values.end()), plain);
  EXPECT_EQ(values.size(), plain.size());
  EXPECT_EQ(values.empty(), plain.empty());
  auto backwards = plain.rbegin();
  for (auto value = values.rbegin(); value != values.rend(); ++value, ++backwards) {
    ASSERT_NE(backwards, plain.rend());
    EXPECT_EQ(value->first, backwards->first);
    EXPECT_EQ(value->second, backwards->second);
  }
  EXPECT_EQ(backwards, plain.rend());
}

// Returns ids as in a map that grows and loses some; and any numbers, which do not occur in a real map.
int64_t DrawId(std::mt19937_64& generator, int step) {
  constexpr int64_t kLowest = std::numeric_limits<int64_t>::min();
  constexpr int64_t kHighest = std::numeric_limits<int64_t>::max();
  switch (generator() % 8) {
    case 0:
      return std::uniform_int_distribution<int64_t>(kLowest, kHighest)(generator);
    case 1:
      return std::uniform_int_distribution<int64_t>(-130, 5)(generator);
    case 2:
      return generator() % 2 == 0 ? kLowest : kHighest;
    default:
      return std::uniform_int_distribution<int64_t>(0, 20 + step)(generator);
  }
}

TEST(IdMap, AgreesWithStdMap) {
  std::mt19937_64 generator(3);
  Texts values;
  Plain plain;
  for (int step = 0; step < 3000; ++step) {
    const KeyframeId id(DrawId(generator, step / 4));
    ASSERT_EQ(values.contains(id), plain.contains(id)) << id;
    switch (generator() % 4) {
      case 0:
        ASSERT_EQ(values.erase(id), plain.erase(id)) << id;
        break;
      case 1:
        ASSERT_EQ(values.try_emplace(id, "tried").second, plain.try_emplace(id, "tried").second) << id;
        break;
      default:
        values[id] = plain[id] = std::to_string(step);
    }
    if (step % 50 == 0) {
      ASSERT_NO_FATAL_FAILURE(ExpectSame(values, plain));
    }
  }
  ExpectSame(values, plain);
  for (const auto& [id, value] : plain) {
    EXPECT_EQ(values.at(id), value);
    EXPECT_EQ(*values.Find(id), value);
  }
  for (const auto& [id, value] : plain) EXPECT_EQ(values.erase(id), 1U);
  ExpectSame(values, {});
}

TEST(IdMap, EmptyMapHasNoBegin) {
  Texts values;
  EXPECT_EQ(values.begin(), values.end());
  EXPECT_EQ(values.rbegin(), values.rend());
  EXPECT_EQ(values.Find(0), nullptr);
  EXPECT_EQ(values.erase(0), 0U);
  EXPECT_THROW(values.at(7), std::out_of_range);
}

TEST(IdMap, IsWalkedInBothDirectionsOverGaps) {
  Texts values;
  for (const KeyframeId id : {1000, 63, 64, 0, -1, 127}) values[id];
  EXPECT_THAT(IdsOf(values), ElementsAre(-1, 0, 63, 64, 127, 1000));
  auto at = values.end();
  EXPECT_EQ((--at)->first, 1000);
  EXPECT_EQ((at--)->first, 1000);
  EXPECT_EQ((at++)->first, 127);
  EXPECT_EQ(++at, values.end());
}

TEST(IdMap, ValuesKeepTheirAddress) {
  Texts values;
  values[5] = "five";
  const std::string* five = values.Find(5);
  for (int id = 2000; id > -2000; --id) values[id == 5 ? 6 : id];
  for (int id = -1000; id < 5; ++id) values.erase(id);
  EXPECT_EQ(values.Find(5), five);
  EXPECT_EQ(*five, "five");
}

TEST(IdMap, CopyIsIndependent) {
  Texts values;
  values[1] = "one";
  values[100] = "hundred";
  Texts copy = values;
  copy[1] = "other";
  copy.erase(100);
  EXPECT_EQ(values.at(1), "one");
  EXPECT_EQ(IdsOf(values), (std::vector<KeyframeId>{1, 100}));
  const Texts moved = std::move(copy);
  EXPECT_EQ(moved.at(1), "other");
  EXPECT_TRUE(copy.empty());  // NOLINT(bugprone-use-after-move): it may be used again
  copy[3] = "three";
  EXPECT_THAT(IdsOf(copy), ElementsAre(3));
  static_assert(std::is_nothrow_move_constructible_v<Texts>);
}

}  // namespace
}  // namespace plslam
