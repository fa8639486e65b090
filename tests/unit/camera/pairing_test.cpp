// SPDX-License-Identifier: BSD-3-Clause
#include "camera/pairing.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace plslam::camera {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

constexpr int64_t kMs = 1'000'000;

using Pairs = std::vector<std::pair<int64_t, int64_t>>;

/// Times in ms of the pairs that are sure.
Pairs Sure(Pairing* pairing) {
  Pairs pairs;
  while (const auto pair = pairing->Pop()) pairs.emplace_back(pair->left.t_ns / kMs, pair->right.t_ns / kMs);
  return pairs;
}

void Add(Pairing* pairing, Side side, const std::vector<int64_t>& times_ms) {
  for (const int64_t t_ms : times_ms) pairing->Add(side, {t_ms * kMs, {}});
}

/// Returns all pairs of complete streams.
Pairs All(Pairing* pairing, const std::vector<int64_t>& left_ms, const std::vector<int64_t>& right_ms) {
  Add(pairing, Side::kLeft, left_ms);
  Add(pairing, Side::kRight, right_ms);
  pairing->End(Side::kLeft);
  pairing->End(Side::kRight);
  return Sure(pairing);
}

TEST(Pairing, SameTimesAreAPairAtOnce) {
  Pairing pairing(0);
  Add(&pairing, Side::kRight, {50});
  EXPECT_THAT(Sure(&pairing), IsEmpty());
  Add(&pairing, Side::kLeft, {50});
  EXPECT_THAT(Sure(&pairing), ElementsAre(Pair(50, 50)));
}

TEST(Pairing, ImagesWithoutAPartnerAreDroppedAndCounted) {
  Pairing pairing(5 * kMs);
  EXPECT_THAT(All(&pairing, {0, 50, 150}, {2, 103, 153, 204}), ElementsAre(Pair(0, 2), Pair(150, 153)));
  EXPECT_EQ(pairing.dropped(Side::kLeft), 1);
  EXPECT_EQ(pairing.dropped(Side::kRight), 1);
}

TEST(Pairing, TheSkewMayBeAsLargeAsTheLimitAndNoLarger) {
  Pairing pairing(5 * kMs);
  EXPECT_THAT(All(&pairing, {0, 50}, {5, 56}), ElementsAre(Pair(0, 5)));
}

TEST(Pairing, NearestPartnerIsTaken) {
  Pairing pairing(30 * kMs);
  // 20 is nearer to 18 than 0 is; 40 to 41.
  EXPECT_THAT(All(&pairing, {0, 20, 40}, {18, 41}), ElementsAre(Pair(20, 18), Pair(40, 41)));
  EXPECT_EQ(pairing.dropped(Side::kLeft), 0) << "that was before the first pair";
}

TEST(Pairing, NextImageOfAFileMayBeNearer) {
  Pairing pairing(5 * kMs);
  Add(&pairing, Side::kLeft, {0, 50});
  Add(&pairing, Side::kRight, {0, 54});
  EXPECT_THAT(Sure(&pairing), ElementsAre(Pair(0, 0)));
  Add(&pairing, Side::kLeft, {56, 100});
  Add(&pairing, Side::kRight, {104});
  EXPECT_THAT(Sure(&pairing), ElementsAre(Pair(56, 54)));
  EXPECT_EQ(pairing.dropped(Side::kLeft), 1);
}

TEST(Pairing, LiveFirstPairWaitsUntilTheRateIsKnown) {
  Pairing pairing(5 * kMs, true);
  Add(&pairing, Side::kLeft, {0});
  Add(&pairing, Side::kRight, {3});
  EXPECT_THAT(Sure(&pairing), IsEmpty()) << "a left image at 4 would be nearer";
  Add(&pairing, Side::kLeft, {50});
  EXPECT_THAT(Sure(&pairing), ElementsAre(Pair(0, 3)));
  Add(&pairing, Side::kRight, {53});
  EXPECT_THAT(Sure(&pairing), ElementsAre(Pair(50, 53)));
}

TEST(Pairing, LiveShortStepDelaysPairsForAWhileOnly) {
  Pairing pairing(5 * kMs, true);
  int64_t t_ms = 0;
  int n_delayed = 0;
  for (int i = 0; i < 300; ++i) {
    t_ms += i == 50 ? 5 : 50;
    Add(&pairing, Side::kLeft, {t_ms});
    Add(&pairing, Side::kRight, {t_ms + 3});
    const Pairs pairs = Sure(&pairing);
    n_delayed += pairs.empty() || pairs.back().first != t_ms;
  }
  EXPECT_GE(n_delayed, 1) << "the short step";
  EXPECT_LE(n_delayed, 101);
}

TEST(Pairing, EndOfACameraReleasesItsLastPair) {
  Pairing pairing(5 * kMs);
  Add(&pairing, Side::kLeft, {0});
  Add(&pairing, Side::kRight, {3});
  EXPECT_TRUE(pairing.End(Side::kLeft));
  EXPECT_FALSE(pairing.End(Side::kLeft)) << "no news";
  EXPECT_THAT(Sure(&pairing), ElementsAre(Pair(0, 3)));
}

TEST(Pairing, TimesThatGoBackAreDropped) {
  Pairing pairing(5 * kMs);
  EXPECT_THAT(All(&pairing, {0, 50, 40, 50, 100}, {0, 50, 100}),
              ElementsAre(Pair(0, 0), Pair(50, 50), Pair(100, 100)));
  EXPECT_EQ(pairing.dropped(Side::kLeft), 2);
}

TEST(Pairing, CameraAloneDoesNotFillTheMemory) {
  Pairing pairing(5 * kMs);
  Add(&pairing, Side::kRight, {-50});
  Add(&pairing, Side::kLeft, {-50});
  EXPECT_EQ(Sure(&pairing).size(), 1U);
  for (int i = 0; i < 1000; ++i) Add(&pairing, Side::kLeft, {50 * i});
  EXPECT_LT(pairing.waiting(Side::kLeft), 100U);
  EXPECT_EQ(pairing.dropped(Side::kLeft) + static_cast<int64_t>(pairing.waiting(Side::kLeft)), 1000);
  pairing.Clear();
  EXPECT_EQ(pairing.waiting(Side::kLeft), 0U);
  Add(&pairing, Side::kLeft, {60'000});
  Add(&pairing, Side::kRight, {60'000});
  EXPECT_THAT(Sure(&pairing), ElementsAre(Pair(60'000, 60'000)));
}

/// Jittered cameras with holes, in whatever turns.
TEST(Pairing, ResultDoesNotDependOnTheArrivalOrder) {
  std::mt19937 random(5);
  std::vector<int64_t> left, right;
  for (int i = 0; i < 200; ++i) {
    const auto t_ms = [&](int jitter_ms) { return 33 * i + static_cast<int64_t>(random() % jitter_ms); };
    if (random() % 10 != 0) left.push_back(t_ms(4));
    if (random() % 10 != 0) right.push_back(t_ms(9));
  }
  Pairing whole(6 * kMs);
  Pairs expected;
  for (size_t i = 0; i < std::max(left.size(), right.size()); ++i) {
    if (i < left.size()) Add(&whole, Side::kLeft, {left[i]});
    if (i < right.size()) Add(&whole, Side::kRight, {right[i]});
    for (const auto& pair : Sure(&whole)) expected.push_back(pair);
  }
  for (const auto& pair : All(&whole, {}, {})) expected.push_back(pair);
  EXPECT_GT(expected.size(), 100U);
  for (const auto& [l, r] : expected) EXPECT_LE(std::abs(l - r), 6);
  for (int trial = 0; trial < 20; ++trial) {
    Pairing pairing(6 * kMs);
    Pairs pairs;
    for (size_t l = 0, r = 0; l < left.size() || r < right.size();) {
      // Neither is ever far ahead, as it is of cameras.
      const bool takes_left =
          r == right.size() || (l < left.size() && (l + 3 < r || (random() % 2 == 0 && l < r + 3)));
      takes_left ? Add(&pairing, Side::kLeft, {left[l++]}) : Add(&pairing, Side::kRight, {right[r++]});
      for (const auto& pair : Sure(&pairing)) pairs.push_back(pair);
    }
    for (const auto& pair : All(&pairing, {}, {})) pairs.push_back(pair);
    EXPECT_EQ(pairs, expected) << "trial " << trial;
    EXPECT_EQ(pairing.dropped(Side::kLeft), whole.dropped(Side::kLeft));
  }
}

}  // namespace
}  // namespace plslam::camera
