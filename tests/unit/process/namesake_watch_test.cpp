// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/namesake_watch.h"

#include <gtest/gtest.h>

#include <string>

namespace plslam::bus {
namespace {

using Action = NamesakeWatch::Action;

ProcessIdentity Identity(int64_t source, double uptime_s, double started_utc_s = 1000.0) {
  return {SourceId(source), "robot", source + 100, uptime_s, started_utc_s};
}

TEST(NamesakeWatch, StartingProcessYieldsToARunningOne) {
  NamesakeWatch watch(2);
  EXPECT_EQ(watch.OnStatus(Identity(1, 60.0), Identity(2, 0.01), 5.0), Action::kNone) << "it may have exited";
  EXPECT_EQ(watch.OnStatus(Identity(1, 60.1), Identity(2, 0.13), 5.12), Action::kYield);
}

TEST(NamesakeWatch, LastStatusOfAnExitedProcessIsNoProof) {
  NamesakeWatch watch(2);
  EXPECT_EQ(watch.OnStatus(Identity(1, 60.0), Identity(2, 0.01), 5.0), Action::kNone);
  EXPECT_EQ(watch.OnStatus(Identity(1, 60.0), Identity(2, 0.02), 5.01), Action::kNone);
}

TEST(NamesakeWatch, CopiesOfAMessageAreNoProof) {
  NamesakeWatch watch(2);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(watch.OnStatus(Identity(1, 900.0), Identity(2, 60.0 + i), 5.0 + i), Action::kNone) << i;
  }
}

TEST(NamesakeWatch, OlderProcessRepliesToAStartingOne) {
  NamesakeWatch watch(1);
  EXPECT_EQ(watch.OnStatus(Identity(2, 0.01), Identity(1, 60.0), 5.0), Action::kReply);
  EXPECT_EQ(watch.OnStatus(Identity(2, 0.2), Identity(1, 60.2), 5.2), Action::kReply);
}

TEST(NamesakeWatch, YoungerOneYieldsAfterANetworkWasSplit) {
  NamesakeWatch young(2), old(1);
  EXPECT_EQ(young.OnStatus(Identity(1, 90.0), Identity(2, 30.0), 5.0), Action::kNone);
  EXPECT_EQ(old.OnStatus(Identity(2, 30.0), Identity(1, 90.0), 5.0), Action::kNone);
  EXPECT_EQ(young.OnStatus(Identity(1, 91.0), Identity(2, 31.0), 6.0), Action::kNone);
  EXPECT_EQ(young.OnStatus(Identity(1, 92.0), Identity(2, 32.0), 7.0), Action::kYield);
  EXPECT_EQ(old.OnStatus(Identity(2, 31.0), Identity(1, 92.0), 7.0), Action::kNone);
}

TEST(NamesakeWatch, ReplayedLogIsReportedOnce) {
  NamesakeWatch watch(1);
  int n = 0;
  for (int s = 0; s < 20; ++s) {
    if (watch.OnStatus(Identity(9, 3.0 + s), Identity(1, 500.0 + s), 5.0 + s) == Action::kReport) ++n;
  }
  EXPECT_EQ(n, 1);
}

TEST(NamesakeWatch, ExactlyOneOfTwoStartedTogetherYields) {
  NamesakeWatch a(1), b(2);
  int yields = 0;
  for (int i = 0; i < 5; ++i) {
    // Each sees the uptime of the other as it was a moment ago.
    const double now_s = 5.0 + 0.1 * i, uptime_s = 0.05 + 0.1 * i;
    yields += a.OnStatus(Identity(2, uptime_s - 0.01), Identity(1, uptime_s), now_s) == Action::kYield ? 1 : 0;
    yields += b.OnStatus(Identity(1, uptime_s - 0.01), Identity(2, uptime_s), now_s) == Action::kYield ? 10 : 0;
  }
  EXPECT_EQ(yields % 10, 0) << "the one with the smaller source stays";
  EXPECT_GE(yields / 10, 1);
}

TEST(NamesakeWatch, SentenceNamesTheProcess) {
  EXPECT_EQ(NamesakeWatch::Sentence("vo", Identity(7, 12.4)),
            "another vo is running on this bus: process 107 on robot, for 12 s");
}

}  // namespace
}  // namespace plslam::bus
