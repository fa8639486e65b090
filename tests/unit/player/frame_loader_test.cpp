// SPDX-License-Identifier: BSD-3-Clause
#include "player/frame_loader.h"

#include <gtest/gtest.h>

#include <atomic>

namespace plslam::player {
namespace {

// Ten frames, the fourth of which cannot be read, and the ninth breaks the reader if `breaks`.
class Frames : public Dataset {
 public:
  std::string name() const override { return "frames"; }
  const RigCalibration& rig() const override { return rig_; }
  int size() const override { return 10; }
  int64_t t_ns(int index) const override { return index; }
  StereoImages Read(int index) const override {
    ++n_reads;
    if (index == 3) throw DatasetError("no frame 3");
    if (index == 8 && breaks) throw std::logic_error("broken");
    return {index, 0, cv::Mat(1, 1, CV_8UC1, cv::Scalar(index)), cv::Mat()};
  }
  std::optional<SE3> GroundTruth(int) const override { return SE3(); }

  mutable std::atomic<int> n_reads = 0;
  bool breaks = false;

 private:
  RigCalibration rig_;
};

PlayOrder Order() {
  return {10, [](int index) { return int64_t{index}; }, {}, 10.0};
}

TEST(FrameLoader, OrderIsKeptAndBadFramesAreReported) {
  const Frames frames;
  FrameLoader loader(frames, Order(), 2);
  for (int i = 0; i < 10; ++i) {
    const auto frame = loader.Next();
    ASSERT_TRUE(frame) << i;
    EXPECT_EQ(frame->images.t_ns, i);
    EXPECT_EQ(frame->error, i == 3 ? "no frame 3" : "");
    if (i == 3) continue;
    EXPECT_EQ(frame->images.left.at<uint8_t>(0, 0), i);
  }
  EXPECT_FALSE(loader.Next());
}

// Samples every 0.3 frames, the first at frame 1.
class SensedFrames : public Frames {
 public:
  SensedFrames() {
    rig_.imu = ImuCalibration();
    for (int64_t t = 1000; t < 9500; t += 300) samples_.emplace_back().t_ns = t;
  }
  const RigCalibration& rig() const override { return rig_; }
  int64_t t_ns(int index) const override { return 1000 * index; }
  const std::vector<ImuSample>& ImuSamples() const override { return samples_; }

 private:
  RigCalibration rig_;
  std::vector<ImuSample> samples_;
};

PlayOrder SensedOrder(int64_t loop) {
  PlayerOptions options;
  options.loop = loop;
  return {10, [](int index) { return int64_t{1000} * index; }, options, 10.0};
}

TEST(FrameLoader, SamplesCoverTheMotionFromFrameToFrame) {
  const SensedFrames frames;
  FrameLoader loader(frames, SensedOrder(2), 2);
  std::vector<LoadedFrame> loaded;
  while (auto frame = loader.Next()) loaded.push_back(*frame);
  ASSERT_EQ(loaded.size(), 20U);
  EXPECT_TRUE(loaded[0].imu.empty()) << "no frame before";
  EXPECT_EQ(loaded[1].imu.front().t_ns, 1000) << "the sensor begins late";
  EXPECT_EQ(loaded[2].imu.front().t_ns, 1000);
  EXPECT_EQ(loaded[2].imu.back().t_ns, 2200);
  EXPECT_EQ(loaded[2].imu.size(), 5U);
  EXPECT_EQ(loaded[4].imu_from_ns, 2000) << "frame 3 cannot be read";
  EXPECT_EQ(loaded[4].imu.front().t_ns, 1900);
  EXPECT_EQ(loaded[4].imu.back().t_ns, 4000);
  EXPECT_TRUE(loaded[10].imu.empty()) << "from the end to the beginning";
  EXPECT_EQ(loaded[12].imu.front().t_ns, 11000) << "on the clock of the second pass";
  EXPECT_EQ(loaded[12].imu.size(), loaded[2].imu.size());
}

TEST(FrameLoader, ResumedSamplesFollowTheLastFrame) {
  const SensedFrames frames;
  PlayOrder order = SensedOrder(1);
  order.SkipTo(5000);
  FrameLoader loader(frames, std::move(order), 2, 5000);
  const auto frame = loader.Next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->images.t_ns, 6000);
  EXPECT_EQ(frame->imu_from_ns, 5000);
  EXPECT_EQ(frame->imu.front().t_ns, 4900);
  EXPECT_EQ(frame->imu.back().t_ns, 6100);
}

TEST(FrameLoader, ReadsNoFurtherAheadThanItsDepth) {
  const Frames frames;
  FrameLoader loader(frames, Order(), 2);
  loader.Next();
  loader.Next();
  // Two taken, two ready, one in the hand of the worker.
  EXPECT_LE(frames.n_reads, 5);
}

TEST(FrameLoader, OtherErrorsLeaveNext) {
  Frames frames;
  frames.breaks = true;
  FrameLoader loader(frames, Order(), 2);
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(loader.Next());
  EXPECT_THROW(loader.Next(), std::logic_error);
}

TEST(FrameLoader, StopsInTheMiddle) {
  const Frames frames;
  FrameLoader loader(frames, Order(), 2);
  loader.Next();
  loader.Stop();
  EXPECT_FALSE(loader.Next());
}

}  // namespace
}  // namespace plslam::player
