// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor/heard_process.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace plslam::doctor {
namespace {

using testing::HasSubstr;

HeardProcess Vo() {
  HeardProcess p;
  p.process = "vo";
  p.host = "robot";
  p.pid = 17;
  p.version = "0.1.0";
  p.state = "running";
  p.source = 1;
  p.schema = 1;
  return p;
}

OwnSide Own() { return {"udpm://239.255.76.67:7667?ttl=1", "", "0.1.0", "here", 1, false}; }

/// Returns the findings that are not good, as text.
std::string FindingsAbout(const Heard& heard, const OwnSide& own) {
  return FindingsToText(CheckProcesses(heard, own), true);
}
std::string FindingsAbout(const HeardProcess& p, const OwnSide& own = Own()) {
  return FindingsAbout(Heard{{p}, {}, 0}, own);
}

TEST(HeardProcess, NoFindings) {
  EXPECT_EQ(FindingsAbout(Vo()), "");
  EXPECT_EQ(FindingsAbout(Heard{}, Own()), "");
}

TEST(HeardProcess, KeysThatDiffer) {
  HeardProcess p = Vo();
  OwnSide with_key = Own();
  with_key.has_key = true;
  EXPECT_THAT(FindingsAbout(p, with_key), HasSubstr("does not sign its messages, and a key is set here"));
  p.signature = Signature::kUnchecked;
  EXPECT_THAT(FindingsAbout(p), HasSubstr("signs its messages, and no key is set here"));
  p.signature = Signature::kWrong;
  EXPECT_THAT(FindingsAbout(p, with_key), HasSubstr("has a key that differs"));
  p.signature = Signature::kGood;
  EXPECT_EQ(FindingsAbout(p, with_key), "");
  p.signature = Signature::kWrong;
  p.prefix = "other/";
  EXPECT_THAT(FindingsAbout(p, with_key), testing::Not(HasSubstr("key")))
      << "another robot's key is its own business";
}

TEST(HeardProcess, VersionsThatDiffer) {
  HeardProcess p = Vo();
  p.version = "0.0.9";
  EXPECT_THAT(FindingsAbout(p), HasSubstr("advice   vo on robot (process 17) is version 0.0.9"));
  p.schema = 7;
  EXPECT_THAT(FindingsAbout(p), HasSubstr("PROBLEM  vo on robot (process 17) uses version 7 of the messages"));
  EXPECT_THAT(FindingsAbout(Heard{{Vo()}, {{"POSE", 40}}, 0}, Own()),
              HasSubstr("40 messages on POSE are not of the type"));
}

TEST(HeardProcess, OnlyAnotherPrefixIsHeard) {
  HeardProcess p = Vo();
  p.prefix = "robot1/";
  EXPECT_THAT(
      FindingsAbout(p),
      HasSubstr("processes with the prefix 'robot1/' were found, but none with the prefix of this host ('')"));
  EXPECT_THAT(FindingsAbout(p), HasSubstr("plslam doctor --prefix robot1/"));
  EXPECT_EQ(FindingsAbout(Heard{{p, Vo()}, {}, 0}, Own()), "") << "two robots side by side";
}

TEST(HeardProcess, TwoMapsUnderOnePrefix) {
  HeardProcess a = Vo(), b = Vo();
  a.process = b.process = "mapping";
  b.source = 2;
  b.pid = 18;
  EXPECT_THAT(FindingsAbout(Heard{{a, b}, {}, 0}, Own()), HasSubstr("mend: ssh robot kill 18"));
  b.prefix = "robot1/";
  EXPECT_EQ(FindingsAbout(Heard{{a, b}, {}, 0}, Own()), "");
  b.prefix = "";
  a.process = b.process = "vo";
  EXPECT_EQ(FindingsAbout(Heard{{a, b}, {}, 0}, Own()), "") << "several cameras in one map";
}

TEST(HeardProcess, FailuresLossAndClocks) {
  HeardProcess p = Vo();
  p.state = "failed";
  p.reason = "disk full";
  EXPECT_THAT(FindingsAbout(p), HasSubstr("has failed: disk full"));
  p = Vo();
  p.counters = {{"bus.received", 900}, {"bus.lost", 100}};
  EXPECT_THAT(FindingsAbout(p), HasSubstr("10.0 % of its messages to be sent again"));
  p.counters = {{"bus.received", 90000}, {"bus.lost", 100}};
  EXPECT_EQ(FindingsAbout(p), "");
  p.counters = {{"bus.rejected", 3}};
  p.reason = "3 messages rejected: another key";
  EXPECT_THAT(FindingsAbout(p), HasSubstr("reports: 3 messages rejected"));
  p = Vo();
  p.clock_ahead_s = -2.5;
  EXPECT_THAT(FindingsAbout(p), HasSubstr("the clock of robot differs by -2.50 s from that of this host"));
  p.host = "here";
  EXPECT_EQ(FindingsAbout(p), "");
}

}  // namespace
}  // namespace plslam::doctor
