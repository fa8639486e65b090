// SPDX-License-Identifier: BSD-3-Clause
#include "camera/image_watch.h"

#include <gtest/gtest.h>

namespace plslam::camera {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr ImageWatch::Time kStart{seconds(1000)};
constexpr milliseconds kPeriod(50);

/// Cameras of 20 Hz whose pipeline plays at the start.
class ImageWatchTest : public testing::Test {
 protected:
  ImageWatchTest() {
    watch_.OnBuild();
    watch_.OnPlay(kStart);
  }
  std::string SilenceAfter(milliseconds time) const { return watch_.Silence(kStart + time, kPeriod); }

  ImageWatch watch_{kStart};
};

TEST_F(ImageWatchTest, FirstImageMayTakeLonger) {
  EXPECT_EQ(SilenceAfter(ImageWatch::kFirstSilence - milliseconds(1)), "");
  EXPECT_EQ(SilenceAfter(ImageWatch::kFirstSilence), "the cameras send no images");
  watch_.OnImage(Side::kLeft, kStart);
  EXPECT_EQ(SilenceAfter(ImageWatch::kSilence - milliseconds(1)), "");
  EXPECT_EQ(SilenceAfter(ImageWatch::kSilence), "the cameras send no images");
  watch_.OnBuild();
  EXPECT_EQ(SilenceAfter(ImageWatch::kSilence), "") << "the next pipeline takes as long";
}

TEST_F(ImageWatchTest, SilentCameraIsNamed) {
  const ImageWatch::Time now = kStart + seconds(5);
  EXPECT_FALSE(watch_.HaveBothSent());
  watch_.OnImage(Side::kLeft, now);
  EXPECT_EQ(watch_.Silence(now, kPeriod), "the right camera sends no images");
  EXPECT_FALSE(watch_.HaveBothSent());
  watch_.OnImage(Side::kRight, now);
  EXPECT_TRUE(watch_.HaveBothSent());
  EXPECT_EQ(watch_.Silence(now, kPeriod), "left and right images have no times in common (source.max_skew_ms)");
  watch_.OnFrame(now);
  EXPECT_EQ(watch_.Silence(now, kPeriod), "");
  watch_.OnImage(Side::kRight, now + seconds(5));
  EXPECT_EQ(watch_.Silence(now + seconds(5), kPeriod), "the left camera sends no images");
}

TEST_F(ImageWatchTest, SlowCamerasHaveTwentyPeriods) {
  watch_.OnImage(Side::kLeft, kStart);
  EXPECT_EQ(watch_.Silence(kStart + seconds(19), seconds(1)), "");
  EXPECT_NE(watch_.Silence(kStart + seconds(20), seconds(1)), "");
}

TEST_F(ImageWatchTest, StallCountsFromTheRequestOrImage) {
  watch_.OnRequest(kStart);
  EXPECT_FALSE(watch_.HasStalled(kStart + seconds(9)));
  EXPECT_TRUE(watch_.HasStalled(kStart + seconds(10)));
  watch_.OnImage(Side::kLeft, kStart + seconds(9));
  EXPECT_FALSE(watch_.HasStalled(kStart + seconds(18)));
  EXPECT_TRUE(watch_.HasStalled(kStart + seconds(19)));
}

TEST_F(ImageWatchTest, FramesEndTheWait) {
  EXPECT_EQ(watch_.SinceFrame(kStart + seconds(3)), seconds(3));
  watch_.OnFrame(kStart + seconds(2));
  EXPECT_EQ(watch_.SinceFrame(kStart + seconds(3)), seconds(1));
  watch_.OnBegin(kStart + seconds(3));
  EXPECT_EQ(watch_.SinceFrame(kStart + seconds(3)), seconds(0));
}

}  // namespace
}  // namespace plslam::camera
