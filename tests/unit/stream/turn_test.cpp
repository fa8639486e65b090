// SPDX-License-Identifier: BSD-3-Clause
#include "core/stream/node/turn.h"

#include <gtest/gtest.h>

#include <thread>

namespace plslam::stream {
namespace {

using std::chrono::milliseconds;
using Event = Turn::Event;

constexpr milliseconds kNow{0};

TEST(Turn, OnlyThePoseOfTheExpectedFrameCounts) {
  Turn turn;
  turn.OnPose({0, 10 * 0});
  turn.Expect({0, 10 * 0});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout);
  turn.OnPose({1, 10 * 1});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout);
  turn.OnPose({0, 10 * 0});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kPose);
  turn.Expect({1, 10 * 1});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout);
}

TEST(Turn, EveryReaderIsNewOnce) {
  Turn turn;
  turn.Expect({0, 10 * 0});
  turn.OnReader(11);
  turn.OnReader(11);
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kNewReader);
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout);
  turn.OnReader(12);
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kNewReader);
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout) << "said once";
}

TEST(Turn, PoseWinsOverANewReader) {
  Turn turn;
  turn.Expect({0, 0});
  turn.OnReader(11);
  turn.OnPose({0, 0});
  turn.OnReader(12);
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kPose);
  turn.Expect({1, 10});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout) << "this frame is sent after both were seen";
}

TEST(Turn, EarlierPosesCountOnlyInAResumedStream) {
  Turn turn;
  turn.OnPose({7, 70});
  turn.OnPose({5, 50});
  EXPECT_EQ(turn.newest(), (ResumePoint{7, 70}));
  turn.Expect({6, 60});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout);
  turn.Resume();
  turn.Expect({6, 60});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kPose);
  turn.Expect({7, 71});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout) << "a frame of this number, but of another stream";
  turn.Expect({8, 80});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout);
}

TEST(Turn, ResendRequestIsReportedOnce) {
  Turn turn;
  turn.OnGoBack(21, {3, 30});
  turn.Expect({7, 70});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kGoBack);
  EXPECT_EQ(turn.GoBack(), (ResumePoint{3, 30}));
  turn.Expect({4, 40});
  turn.OnGoBack(21, {3, 30});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout) << "said again";
  turn.OnGoBack(22, {3, 30});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kGoBack) << "another has not got frame 4";
  EXPECT_EQ(turn.GoBack(), (ResumePoint{3, 30}));
  turn.Expect({4, 40});
  turn.OnGoBack(22, {9, 90});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout) << "such a frame has not been sent";
}

TEST(Turn, ResendRequestAfterAllFramesWereAnswered) {
  Turn turn;
  turn.Expect({7, 70});
  turn.OnPose({7, 70});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kPose);
  EXPECT_FALSE(turn.WaitForRewind(kNow));
  turn.OnGoBack(21, {3, 30});
  EXPECT_TRUE(turn.WaitForRewind(milliseconds(100000)));
  EXPECT_EQ(turn.GoBack(), (ResumePoint{3, 30}));
  turn.Stop();
  EXPECT_FALSE(turn.WaitForRewind(milliseconds(100000)));
}

TEST(Turn, PosesAfterTheResendPointDoNotCount) {
  Turn turn;
  turn.OnPose({7, 70});
  turn.Resume();
  turn.OnGoBack(21, {3, 30});
  turn.Expect({8, 80});
  ASSERT_EQ(turn.WaitForPose(kNow), Event::kGoBack);
  turn.GoBack();
  turn.OnPose({7, 70});
  turn.Expect({4, 40});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kTimeout) << "said again for the dead";
  turn.OnPose({4, 40});
  EXPECT_EQ(turn.WaitForPose(kNow), Event::kPose);
}

TEST(Turn, PauseEndsByResumeResendRequestOrStop) {
  Turn turn;
  EXPECT_EQ(turn.WaitWhilePaused(), Event::kPose);
  turn.SetPaused(true);
  turn.Expect({8, 80});
  turn.OnGoBack(21, {3, 30});
  EXPECT_EQ(turn.WaitWhilePaused(), Event::kGoBack);
  turn.GoBack();
  std::thread somebody([&turn] { turn.SetPaused(false); });
  EXPECT_EQ(turn.WaitWhilePaused(), Event::kPose);
  somebody.join();
  EXPECT_TRUE(turn.is_running());
  turn.SetPaused(true);
  EXPECT_FALSE(turn.is_running());
  turn.Stop();
  EXPECT_EQ(turn.WaitWhilePaused(), Event::kStopped);
  turn.SetPaused(false);
  EXPECT_FALSE(turn.is_running()) << "an order that arrives too late";
}

TEST(Turn, StopEndsEveryWait) {
  Turn turn;
  turn.Expect({0, 10 * 0});
  turn.Stop();
  EXPECT_EQ(turn.WaitForPose(milliseconds(100000)), Event::kStopped);
  EXPECT_FALSE(turn.WaitUntil(Turn::Clock::now() + milliseconds(100000)));
}

}  // namespace
}  // namespace plslam::stream
