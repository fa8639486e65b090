// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/white_level.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <set>

#include "core/datasets/open_dataset.h"
#include "core/files/dataset_error.h"
#include "core/io/images/image_file.h"
#include "core/io/images/png_codec.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(WhiteLevelOf, IsOfTheBrightestOfManyFrames) {
  std::set<int> sampled;
  const auto bright_of = [&](int frame) {
    sampled.insert(frame);
    return frame < 500 ? BrightValues{100, 90} : BrightValues{3000, 3100};
  };
  Notes notes;
  EXPECT_EQ(WhiteLevelOf(1000, bright_of, &notes), 4095);
  EXPECT_EQ(sampled.size(), 16U);
  EXPECT_EQ(*sampled.begin(), 0);
  EXPECT_EQ(*sampled.rbegin(), 999);
  EXPECT_TRUE(notes.warnings.empty());
  EXPECT_THAT(notes.remarks, ElementsAre(HasSubstr("values up to 3100, as with 12 bits: 4095 is mapped to white")));
  EXPECT_EQ(WhiteLevelOf(1, bright_of, &notes), 255);
}

TEST(WhiteLevelOf, ReadsOnePairOfEightBits) {
  int n = 0;
  Notes notes;
  EXPECT_EQ(WhiteLevelOf(
                1000, [&](int) { return ++n, BrightValues{}; }, &notes),
            kWhiteOf16Bits);
  EXPECT_EQ(n, 1);
  EXPECT_TRUE(notes.empty());
}

TEST(WhiteLevelOf, RejectsPairsOfDifferentDepth) {
  Notes notes;
  EXPECT_THAT(ErrorOf([&] {
                WhiteLevelOf(
                    3,
                    [](int) {
                      return BrightValues{0, 900};
                    },
                    &notes);
              }),
              HasSubstr("the left image of frame 0 has 8 bits a pixel, and the right one 16"));
}

TEST(BrightWideValue, IgnoresHotPixels) {
  cv::Mat image(100, 100, CV_16UC1, cv::Scalar(40));
  image.rowRange(50, 60) = cv::Scalar(900);
  EXPECT_EQ(BrightWideValue(image), 900);
  image.at<uint16_t>(5, 7) = 65535;
  EXPECT_EQ(BrightWideValue(image), 900);
  for (int x = 0; x < 10; ++x) image.at<uint16_t>(1, x) = 4000;
  EXPECT_EQ(BrightWideValue(image), 4000) << "11 of 10,000 are more than a thousandth";
  EXPECT_EQ(BrightWideValue(cv::Mat(4, 4, CV_16UC1, cv::Scalar(0))), 1) << "black";
}

class WideImages : public testing::Test {
 protected:
  WideImages() {
    test::MakeImagesFolder(folder_);
    fs::remove_all(folder_ / "left");
    fs::remove_all(folder_ / "right");
    fs::create_directories(folder_ / "left");
    fs::create_directories(folder_ / "right");
  }

  void WriteFrame(int frame, int value) const {
    for (const char* side : {"left", "right"}) {
      WritePng((folder_ / side / (std::to_string(frame) + ".png")).string(),
               cv::Mat(test::kTinyHeight_px, test::kTinyWidth_px, CV_16UC1, cv::Scalar(value)));
    }
  }

  test::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path() / "own";
};

TEST_F(WideImages, ClippedFramesAreCounted) {
  std::string times;
  for (int i = 0; i < 40; ++i) {
    WriteFrame(i, i == 21 || i == 22 ? 3000 : 700);
    times += std::to_string(0.1 * i) + "\n";
  }
  test::WriteText(folder_ / "times.txt", times);
  fs::remove(folder_ / "groundtruth.txt");
  const auto dataset = OpenDataset(folder_.string(), "");
  EXPECT_TRUE(dataset->Notes().warnings.empty());
  for (int i = 0; i < 21; ++i) dataset->Read(i);
  EXPECT_TRUE(dataset->NotesOfReading().empty());
  for (int i = 21; i < 40; ++i) dataset->Read(i);
  EXPECT_THAT(
      dataset->NotesOfReading().warnings,
      ElementsAre(HasSubstr("2 frames so far have values above 1023, which is taken as the white of 10 bits, and "
                            "are clipped (the first is frame 21)")));
}

TEST_F(WideImages, LeftOfEightBitsAndRightOfSixteen) {
  for (int i = 0; i < 3; ++i) {
    WriteFrame(i, 900);
    WritePng((folder_ / "left" / (std::to_string(i) + ".png")).string(),
             cv::Mat(test::kTinyHeight_px, test::kTinyWidth_px, CV_8UC1, cv::Scalar(200)));
  }
  EXPECT_THAT(ErrorOf([&] { OpenDataset(folder_.string(), ""); }),
              HasSubstr(folder_.string() + ": the left image of frame 0 has 8 bits a pixel, and the right one 16"));
}

}  // namespace
}  // namespace plslam
