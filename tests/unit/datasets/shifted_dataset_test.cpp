// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/open_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kFiveFrames = "synthetic:room?size=64x48&frames=5&noise=0";

bool Same(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) == 0.0; }

TEST(ShiftedDataset, LeftImagesGetTheRightOnesOfOtherFrames) {
  const auto original = OpenDataset(kFiveFrames, "");
  for (const int offset : {-2, -1, 0, 1, 3}) {
    const auto shifted = ShiftRightImages(OpenDataset(kFiveFrames, ""), offset);
    ASSERT_EQ(shifted->size(), 5 - std::abs(offset)) << offset;
    for (int i = 0; i < shifted->size(); ++i) {
      const int left = i + std::max(-offset, 0);
      const StereoImages images = shifted->Read(i);
      EXPECT_TRUE(Same(images.left, original->Read(left).left)) << offset;
      EXPECT_TRUE(Same(images.right, original->Read(left + offset).right)) << offset;
      EXPECT_EQ(images.frame_id, i);
      EXPECT_EQ(shifted->t_ns(i), original->t_ns(left));
      EXPECT_EQ(shifted->GroundTruth(i)->matrix(), original->GroundTruth(left)->matrix());
    }
  }
}

TEST(ShiftedDataset, NoPairsLeftIsAnError) {
  EXPECT_THAT(test::ErrorOf([] { ShiftRightImages(OpenDataset(kFiveFrames, ""), -5); }),
              AllOf(HasSubstr("player.right_offset_frames=-5"), HasSubstr("none of its 5 frames")));
}

}  // namespace
}  // namespace plslam
