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
