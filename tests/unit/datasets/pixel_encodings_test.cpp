// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/pixel_encodings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <vector>

#include "core/io/images/image_file.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 8, kHeight = 6;
const cv::Size kSize(kWidth, kHeight);

cv::Mat Grey(const std::string& encoding, const std::vector<uint8_t>& bytes, int64_t step_bytes = 0,
             bool is_big_endian = false, int white = kWhiteOf16Bits) {
  return GreyOfRosPixels({kWidth, kHeight, step_bytes, encoding, is_big_endian, bytes}, kSize, white);
}

/// The value of all pixels, or -1.
int OneValue(const cv::Mat& grey) {
  const int first = grey.at<uint8_t>(0, 0);
  return cv::countNonZero(grey != first) == 0 ? first : -1;
}

/// A wall of one colour, as a Bayer pattern; `rows` are its upper left two by two pixels.
std::vector<uint8_t> Mosaic(const std::string& rows, bool is_wide) {
  std::vector<uint8_t> bytes;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const char colour = rows[static_cast<size_t>(2 * (y % 2) + x % 2)];
      if (is_wide) bytes.push_back(0);
      bytes.push_back(colour == 'r' ? 200 : colour == 'g' ? 100 : 50);
    }
  }
  return bytes;
}

TEST(PixelEncodings, BayerPatternsBecomeTheGreyOfTheirColour) {
  // 0.299 200 + 0.587 100 + 0.114 50
  for (const char* rows : {"rggb", "grbg", "bggr", "gbrg"}) {
    const std::string name = std::string("bayer_") + rows;
    EXPECT_EQ(OneValue(Grey(name + "8", Mosaic(rows, false))), 124) << rows;
    EXPECT_NEAR(OneValue(Grey(name + "16", Mosaic(rows, true))), 124, 1) << rows;
  }
}

TEST(PixelEncodings, LumaOfYuv) {
  std::vector<uint8_t> yuyv, uyvy, planar;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const auto y = static_cast<uint8_t>(5 * i), chroma = static_cast<uint8_t>(200 - i);
    yuyv.insert(yuyv.end(), {y, chroma});
    uyvy.insert(uyvy.end(), {chroma, y});
    planar.push_back(y);
  }
  const cv::Mat expected = Grey("mono8", planar);
  EXPECT_EQ(expected.at<uint8_t>(1, 2), 50);
  const auto same = [&](const cv::Mat& grey) { return cv::norm(grey, expected, cv::NORM_INF) == 0.0; };
  for (const char* name : {"yuv422_yuy2", "yuyv"}) EXPECT_TRUE(same(Grey(name, yuyv))) << name;
  for (const char* name : {"yuv422", "uyvy"}) EXPECT_TRUE(same(Grey(name, uyvy))) << name;
  planar.resize(kWidth * kHeight * 3 / 2, 128);
  for (const char* name : {"nv12", "nv21", "i420", "yv12", "yuv420"}) EXPECT_TRUE(same(Grey(name, planar))) << name;
  planar.resize(kWidth * kHeight * 2, 128);
  EXPECT_TRUE(same(Grey("nv16", planar)));
  planar.resize(kWidth * kHeight * 3, 128);
  EXPECT_TRUE(same(Grey("nv24", planar)));
}

TEST(PixelEncodings, PlanarYuvWithoutItsColoursIsRefused) {
  const std::vector<uint8_t> luma(kWidth * kHeight);
  EXPECT_THAT(test::ErrorOf([&] { Grey("nv12", luma); }),
              HasSubstr("has 48 bytes in rows of 8 for 8 x 6 pixels of nv12"));
  const std::vector<uint8_t> whole(kWidth * kHeight * 3 / 2);
  EXPECT_THAT(test::ErrorOf([&] { Grey("nv12", whole, kWidth * 3 / 2); }), HasSubstr("in rows of 12"));
}

TEST(PixelEncodings, SixteenBitsInEitherOrderAndOfFewerBits) {
  std::vector<uint8_t> little, big;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    little.insert(little.end(), {0xff, 0x01});  // 511
    big.insert(big.end(), {0x01, 0xff});
  }
  for (const char* name : {"mono16", "16UC1"}) {
    EXPECT_EQ(OneValue(Grey(name, little)), 2) << name;
    EXPECT_EQ(OneValue(Grey(name, little, 0, false, 1023)), 127) << name;
    EXPECT_EQ(OneValue(Grey(name, big, 0, true, 1023)), 127) << name;
    EXPECT_EQ(OneValue(Grey(name, little, 0, false, 255)), 255) << name;
    EXPECT_EQ(BrightWideValue({kWidth, kHeight, 0, name, false, little}, kSize), 511) << name;
  }
  EXPECT_EQ(BrightWideValue({kWidth, kHeight, 0, "yuyv", false, little}, kSize), 0);
}

TEST(PixelEncodings, WhiteLevelUsesTheFewestBits) {
  EXPECT_EQ(WhiteLevel(0), 65535);
  EXPECT_EQ(WhiteLevel(1), 65535) << "a black image";
  EXPECT_EQ(WhiteLevel(255), 255);
  EXPECT_EQ(WhiteLevel(256), 1023);
  EXPECT_EQ(WhiteLevel(1023), 1023);
  EXPECT_EQ(WhiteLevel(1024), 4095);
  EXPECT_EQ(WhiteLevel(4096), 16383);
  EXPECT_EQ(WhiteLevel(16384), 65535);
  EXPECT_EQ(WhiteLevel(65535), 65535);
}

TEST(PixelEncodings, OthersAreNamed) {
  EXPECT_EQ(PixelEncodingComplaint("bayer_grbg16"), "");
  EXPECT_THAT(PixelEncodingComplaint("32FC1"), HasSubstr("encoded as '32FC1', not as mono"));
  EXPECT_THAT(test::ErrorOf([] { Grey("rgb\n", {}); }), HasSubstr("'rgb\\x0a'"));
}

}  // namespace
}  // namespace plslam
