// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/waiting_keyframes.h"

#include <gtest/gtest.h>

namespace plslam::dense {
namespace {

constexpr SessionId kSession = 7;

Keyframe KeyframeOf(int64_t frame, bool lockstep = true) {
  Keyframe keyframe;
  keyframe.name = {.session = kSession, .number = frame};
  keyframe.frame_id = FrameId(frame);
  keyframe.t_ns = 1000 * frame;
  keyframe.lockstep = lockstep;
  return keyframe;
}

StereoImages ImagesOf(int64_t frame) {
  StereoImages images;
  images.frame_id = FrameId(frame);
  images.t_ns = 1000 * frame;
  return images;
}

/// The tracker has found no bodies in a frame.
void AddNoBodies(int64_t frame, WaitingKeyframes& waiting) { waiting.AddBodies({FrameId(frame), 1000 * frame}, {}); }

std::vector<ReadyKeyframe> TakeAll(WaitingKeyframes& waiting) {
  return waiting.Take([](const Keyframe&) { return true; });
}

TEST(WaitingKeyframes, NeedImagesAndAPlace) {
  for (const bool images_first : {true, false}) {
    WaitingKeyframes waiting;
    AddNoBodies(3, waiting);
    if (images_first) {
      EXPECT_FALSE(waiting.AddImages(ImagesOf(3))) << "no keyframe waits for them yet";
    }
    waiting.Add(KeyframeOf(3));
    if (!images_first) {
      EXPECT_TRUE(TakeAll(waiting).empty());
      EXPECT_TRUE(waiting.AddImages(ImagesOf(3)));
    }
    EXPECT_TRUE(waiting.Take([](const Keyframe&) { return false; }).empty());
    EXPECT_EQ(waiting.size(), 1U);
    const std::vector<ReadyKeyframe> ready = TakeAll(waiting);
    ASSERT_EQ(ready.size(), 1U);
    EXPECT_EQ(ready[0].keyframe.name, KeyframeOf(3).name);
    EXPECT_EQ(ready[0].images.t_ns, 3000);
    EXPECT_TRUE(waiting.empty());
  }
}

TEST(WaitingKeyframes, ImagesOfAnotherTimeAreOfAnotherStream) {
  WaitingKeyframes waiting;
  StereoImages images = ImagesOf(3);
  images.t_ns += 1;
  waiting.AddImages(images);
  waiting.Add(KeyframeOf(3));
  EXPECT_FALSE(waiting.AddImages(images));
  EXPECT_TRUE(TakeAll(waiting).empty());
}

// A keyframe without them could show a moving car as a wall.
TEST(WaitingKeyframes, NeedTheTracksOfTheirFrame) {
  WaitingKeyframes waiting;
  waiting.AddImages(ImagesOf(3));
  waiting.Add(KeyframeOf(3));
  EXPECT_TRUE(TakeAll(waiting).empty());
  EXPECT_FALSE(waiting.HasComplete());
  EXPECT_TRUE(waiting.AddBodies({3, 3000}, {}));
  EXPECT_EQ(TakeAll(waiting).size(), 1U);
}

TEST(WaitingKeyframes, AreTakenInTheirOrder) {
  WaitingKeyframes waiting;
  for (const int64_t frame : {5, 2, 9}) {
    waiting.Add(KeyframeOf(frame));
    waiting.AddImages(ImagesOf(frame));
    AddNoBodies(frame, waiting);
  }
  const std::vector<ReadyKeyframe> ready = TakeAll(waiting);
  ASSERT_EQ(ready.size(), 3U);
  EXPECT_EQ(ready[0].keyframe.frame_id, 2);
  EXPECT_EQ(ready[1].keyframe.frame_id, 5);
  EXPECT_EQ(ready[2].keyframe.frame_id, 9);
}

TEST(WaitingKeyframes, HaveMasksAndBodiesOfTheirFrame) {
  WaitingKeyframes waiting;
  const MaskPolygon polygon{.corners_px = {{0.0F, 0.0F}, {4.0F, 0.0F}, {4.0F, 4.0F}}};
  waiting.AddMask({3, 3000}, FrameMask{.left = {polygon}, .right = {}});
  waiting.AddBodies({3, 3000}, {{1, {{10.0F, 20.0F}}}});
  AddNoBodies(4, waiting);
  for (const int64_t frame : {3, 4}) {
    waiting.AddImages(ImagesOf(frame));
    waiting.Add(KeyframeOf(frame));
  }
  const std::vector<ReadyKeyframe> ready = TakeAll(waiting);
  ASSERT_EQ(ready.size(), 2U);
  EXPECT_EQ(ready[0].mask.left, std::vector{polygon});
  ASSERT_EQ(ready[0].bodies.size(), 1U);
  EXPECT_EQ(ready[0].bodies.at(1).size(), 1U);
  EXPECT_TRUE(ready[1].mask.left.empty());
  EXPECT_TRUE(ready[1].bodies.empty());
}

TEST(WaitingKeyframes, KeepWhatWasReceivedOfTheirFrame) {
  WaitingKeyframes waiting;
  constexpr auto kMost = static_cast<int64_t>(WaitingKeyframes::kMostFrames);
  const MaskPolygon polygon{.corners_px = {{0.0F, 0.0F}, {4.0F, 0.0F}, {4.0F, 4.0F}}};
  waiting.AddMask({3, 3000}, FrameMask{.left = {polygon}, .right = {}});
  waiting.AddImages(ImagesOf(3));
  waiting.Add(KeyframeOf(3));
  waiting.AddBodies({3, 3000}, {{1, {{10.0F, 20.0F}}}});
  // The map adds the keyframe late: the frames of the time in between are newer.
  for (int64_t frame = 4; frame < 4 + 2 * kMost; ++frame) waiting.AddImages(ImagesOf(frame));
  const std::vector<ReadyKeyframe> ready = TakeAll(waiting);
  ASSERT_EQ(ready.size(), 1U);
  EXPECT_EQ(ready[0].mask.left.size(), 1U);
  EXPECT_EQ(ready[0].bodies.size(), 1U);
}

TEST(WaitingKeyframes, AnotherStreamBeginsWithTheSameFrames) {
  WaitingKeyframes waiting;
  for (int64_t frame = 100; frame < 130; ++frame) waiting.AddImages(ImagesOf(frame));
  const MaskPolygon polygon{.corners_px = {{0.0F, 0.0F}, {4.0F, 0.0F}, {4.0F, 4.0F}}};
  waiting.AddMask({1, 777}, FrameMask{.left = {polygon}, .right = {}});
  for (int64_t frame = 0; frame < 3; ++frame) {
    waiting.AddImages(ImagesOf(frame));
    AddNoBodies(frame, waiting);
    waiting.Add(KeyframeOf(frame));
  }
  const std::vector<ReadyKeyframe> ready = TakeAll(waiting);
  ASSERT_EQ(ready.size(), 3U);
  EXPECT_TRUE(ready[1].mask.left.empty()) << "a mask of another time is of another stream";
}

TEST(WaitingKeyframes, OnlyTheNewestFramesAreKept) {
  WaitingKeyframes waiting;
  constexpr auto kMost = static_cast<int64_t>(WaitingKeyframes::kMostFrames);
  for (int64_t frame = 0; frame <= kMost; ++frame) {
    waiting.AddImages(ImagesOf(frame));
    AddNoBodies(frame, waiting);
  }
  waiting.Add(KeyframeOf(0));
  waiting.Add(KeyframeOf(1));
  const std::vector<ReadyKeyframe> ready = TakeAll(waiting);
  ASSERT_EQ(ready.size(), 1U);
  EXPECT_EQ(ready[0].keyframe.frame_id, 1);
}

TEST(WaitingKeyframes, ThoseWithoutImagesAreDroppedFirst) {
  WaitingKeyframes waiting;
  constexpr auto kMost = static_cast<int64_t>(WaitingKeyframes::kMostWaiting);
  for (int64_t frame = 0; frame <= kMost; ++frame) {
    waiting.AddImages(ImagesOf(frame == 5 ? 1000 : frame));
    AddNoBodies(frame, waiting);
    waiting.Add(KeyframeOf(frame, false));
  }
  EXPECT_EQ(waiting.size(), WaitingKeyframes::kMostWaiting);
  EXPECT_EQ(waiting.n_incomplete(), 1);
  EXPECT_EQ(waiting.n_dropped(), 0);
  waiting.AddImages(ImagesOf(500));
  AddNoBodies(500, waiting);
  waiting.Add(KeyframeOf(500, false));
  EXPECT_EQ(waiting.n_dropped(), 1);
  const std::vector<ReadyKeyframe> ready = TakeAll(waiting);
  ASSERT_EQ(ready.size(), WaitingKeyframes::kMostWaiting);
  EXPECT_EQ(ready[0].keyframe.frame_id, 1) << "the oldest one was dropped";
}

TEST(WaitingKeyframes, LockstepDropsNoneWithImages) {
  WaitingKeyframes waiting;
  for (int64_t frame = 0; frame < 40; ++frame) {
    waiting.AddImages(ImagesOf(frame));
    AddNoBodies(frame, waiting);
    waiting.Add(KeyframeOf(frame));
  }
  EXPECT_EQ(waiting.size(), 40U);
  waiting.Clear();
  EXPECT_TRUE(waiting.empty());
  EXPECT_EQ(waiting.n_dropped() + waiting.n_incomplete(), 0);
}

}  // namespace
}  // namespace plslam::dense
