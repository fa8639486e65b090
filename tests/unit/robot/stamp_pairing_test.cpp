// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/stamp_pairing.h"

#include <gtest/gtest.h>

namespace plslam::robot {
namespace {

struct Stamped {
  int64_t t_ns = 0;
  Side side = Side::kLeft;
};

class Pairing {
 public:
  explicit Pairing(int64_t max_skew_ns) : pairing_(max_skew_ns) {}

  /// Returns the stamps of the pair that this image completes; {-1, -1} if it completes none.
  std::pair<int64_t, int64_t> Add(Side side, int64_t t_ns) {
    const auto pair = pairing_.Add(side, Stamped{t_ns, side});
    if (!pair) return {-1, -1};
    EXPECT_EQ(pair->first.side, Side::kLeft);
    EXPECT_EQ(pair->second.side, Side::kRight);
    return {pair->first.t_ns, pair->second.t_ns};
  }
  int64_t unpaired() const { return pairing_.unpaired(); }

 private:
  StampPairing<Stamped> pairing_;
};

constexpr std::pair<int64_t, int64_t> kNone = {-1, -1};

TEST(StampPairing, PairsInEitherOrder) {
  Pairing pairing(0);
  EXPECT_EQ(pairing.Add(Side::kLeft, 100), kNone);
  EXPECT_EQ(pairing.Add(Side::kRight, 100), std::pair(int64_t{100}, int64_t{100}));
  EXPECT_EQ(pairing.Add(Side::kRight, 200), kNone);
  EXPECT_EQ(pairing.Add(Side::kLeft, 200), std::pair(int64_t{200}, int64_t{200}));
  EXPECT_EQ(pairing.unpaired(), 0);
}

TEST(StampPairing, NearestWithinTheSkew) {
  Pairing pairing(10);
  EXPECT_EQ(pairing.Add(Side::kLeft, 100), kNone);
  EXPECT_EQ(pairing.Add(Side::kLeft, 120), kNone);
  EXPECT_EQ(pairing.Add(Side::kRight, 111), std::pair(int64_t{120}, int64_t{111}));
  EXPECT_EQ(pairing.unpaired(), 1);
  EXPECT_EQ(pairing.Add(Side::kLeft, 140), kNone);
  EXPECT_EQ(pairing.Add(Side::kRight, 151), kNone);
}

TEST(StampPairing, LostImageDoesNotShiftLaterPairs) {
  constexpr int64_t kFrame_ns = 16'700'000, kSkew_ns = 2'000'000;
  Pairing pairing(20'000'000);
  for (int64_t i = 0; i < 100; ++i) {
    const int64_t t_ns = i * kFrame_ns;
    const bool is_lost = i == 1 || i == 40;
    if (!is_lost) {
      EXPECT_EQ(pairing.Add(Side::kLeft, t_ns), kNone) << i;
    }
    const auto pair = is_lost ? kNone : std::pair(t_ns, t_ns + kSkew_ns);
    EXPECT_EQ(pairing.Add(Side::kRight, t_ns + kSkew_ns), pair) << i;
  }
  EXPECT_EQ(pairing.unpaired(), 2);
}

TEST(StampPairing, OneShortStepIsNoPeriod) {
  Pairing pairing(5'000'000);
  int64_t t_ns = 0;
  for (int64_t i = 0; i < 100; ++i) {
    t_ns += i == 50 ? 5'000'000 : 50'000'000;
    EXPECT_EQ(pairing.Add(Side::kLeft, t_ns), kNone) << i;
    EXPECT_EQ(pairing.Add(Side::kRight, t_ns + 3'000'000), std::pair(t_ns, t_ns + 3'000'000)) << i;
  }
}

TEST(StampPairing, LostImagesAreCountedWithoutDelay) {
  Pairing pairing(0);
  for (int64_t t = 0; t < 1000; ++t) {
    EXPECT_EQ(pairing.Add(Side::kLeft, t), kNone);
    if (t % 2 == 1) {
      EXPECT_EQ(pairing.Add(Side::kRight, t), std::pair(t, t));
    }
  }
  EXPECT_EQ(pairing.unpaired(), 500);
}

TEST(StampPairing, ImagesASecondLate) {
  constexpr int64_t kFrame_ns = 50'000'000, kLate = 20;
  Pairing pairing(5'000'000);
  for (int64_t i = 0; i < 100; ++i) {
    EXPECT_EQ(pairing.Add(Side::kLeft, i * kFrame_ns), kNone);
    if (i < kLate) continue;
    const int64_t t_ns = (i - kLate) * kFrame_ns;
    EXPECT_EQ(pairing.Add(Side::kRight, t_ns), std::pair(t_ns, t_ns));
  }
  EXPECT_EQ(pairing.unpaired(), 0);
}

TEST(StampPairing, FewImagesAreKeptForASilentCamera) {
  Pairing pairing(0);
  for (int64_t i = 0; i < 1000; ++i) pairing.Add(Side::kLeft, i * 50'000'000);
  EXPECT_EQ(pairing.unpaired(), 1000 - 31) << "1.5 s of them wait";
  for (int64_t i = 0; i < 1000; ++i) pairing.Add(Side::kRight, i);
  EXPECT_EQ(pairing.unpaired(), 1000 - 31 + 1000 - 128);
}

// A robot that was started again, or a log that is played again: times go back.
TEST(StampPairing, TimesThatGoBack) {
  Pairing pairing(0);
  for (int64_t t = 1000; t < 1010; ++t) pairing.Add(Side::kLeft, t);
  EXPECT_EQ(pairing.Add(Side::kRight, 5), kNone);
  EXPECT_EQ(pairing.Add(Side::kLeft, 5), std::pair(int64_t{5}, int64_t{5}));
}

}  // namespace
}  // namespace plslam::robot
