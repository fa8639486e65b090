// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/session_anchor.h"

#include <gtest/gtest.h>

namespace plslam::vo {
namespace {

using State = SessionAnchor::State;

constexpr int64_t kS = 1'000'000'000;

TEST(SessionAnchor, FirstSessionOfAMapIsAnchored) {
  SessionAnchor anchor;
  anchor.Begin(10 * kS);
  EXPECT_EQ(anchor.state(), State::kUnknown);
  EXPECT_FALSE(anchor.OnFrame(11 * kS, false, false, false)) << "not counted before it is known";
  anchor.OnMap(true);
  EXPECT_EQ(anchor.state(), State::kAnchored);
  anchor.OnMap(false);
  EXPECT_EQ(anchor.state(), State::kAnchored) << "only a loss changes that, of which odometry knows";
  EXPECT_TRUE(anchor.OnFrame(12 * kS, false, false, true));
}

TEST(SessionAnchor, RecognisedByRelocalisation) {
  SessionAnchor anchor;
  anchor.Begin(10 * kS);
  anchor.OnMap(false);
  EXPECT_TRUE(anchor.OnFrame(11 * kS, false, false, false));
  EXPECT_EQ(anchor.t_ns(), 10 * kS);
  EXPECT_FALSE(anchor.OnFrame(12 * kS, false, true, false));
  EXPECT_EQ(anchor.state(), State::kAnchored);
  EXPECT_EQ(anchor.t_ns(), 12 * kS);
}

TEST(SessionAnchor, RecognisedByItsKeyframes) {
  SessionAnchor anchor;
  anchor.Begin(0);
  anchor.OnMap(false);
  anchor.OnMap(true);
  EXPECT_FALSE(anchor.OnFrame(kS, false, false, false));
}

TEST(SessionAnchor, RequestsEndAfterAWhile) {
  SessionAnchor anchor;
  anchor.Begin(10 * kS);
  anchor.OnMap(false);
  EXPECT_TRUE(anchor.IsRecent(12 * kS));
  EXPECT_FALSE(anchor.IsRecent(14 * kS));
}

}  // namespace
}  // namespace plslam::vo
