// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/rejections.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plslam::bus {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

TEST(Rejections, NoLineWithoutRejections) { EXPECT_EQ(Rejections().Line(0), ""); }

TEST(Rejections, ManyRejectionsGiveOneLine) {
  Rejections rejections;
  EXPECT_TRUE(rejections.Count(Rejection::kOtherKey, "POSE", 0)) << "the first is worth a line in the log";
  for (int i = 0; i < 999; ++i) EXPECT_FALSE(rejections.Count(Rejection::kOtherKey, "POSE", kSecond));
  EXPECT_TRUE(rejections.Count(Rejection::kMalformed, "STATUS", kSecond));
  EXPECT_EQ(rejections.Line(2 * kSecond),
            "messages rejected: 1 malformed (STATUS), 1000 altered or with another bus.key_file (POSE)");
}

TEST(Rejections, PastRejectionsDisappearAfterAMinute) {
  Rejections rejections;
  rejections.Count(Rejection::kOtherVersion, "POSE", 0);
  rejections.OtherPrefix("robot2/", 0);
  EXPECT_EQ(rejections.Line(59 * kSecond),
            "messages rejected: 1 of another version (POSE); processes with prefix 'robot2/' were found, too");
  EXPECT_EQ(rejections.Line(61 * kSecond), "");
}

TEST(Rejections, AllKindsFitIntoAStatus) {
  Rejections rejections;
  for (int why = 0; why < static_cast<int>(Rejection::kNumber); ++why) {
    EXPECT_FALSE(Rejections::Text(static_cast<Rejection>(why)).empty()) << why;
    for (int i = 0; i < 99'999; ++i) rejections.Count(static_cast<Rejection>(why), "REPAIR_REQUEST", 0);
  }
  EXPECT_LE(rejections.Line(0).size(), 310U) << rejections.Line(0);
}

TEST(Rejections, FewPrefixesAndPlainOnes) {
  Rejections rejections;
  EXPECT_TRUE(rejections.OtherPrefix("a\x1b[31m'/", 0));
  EXPECT_FALSE(rejections.OtherPrefix("a\x1b[31m'/", 0));
  for (int i = 0; i < 100; ++i) rejections.OtherPrefix(std::string(200, static_cast<char>('b' + i % 20)), 0);
  EXPECT_THAT(rejections.Line(0), testing::HasSubstr("'a?[31m?/'"));
  EXPECT_LE(rejections.Line(0).size(), 300U) << rejections.Line(0);
}

}  // namespace
}  // namespace plslam::bus
