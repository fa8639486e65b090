// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/foreign_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/files/dataset_error.h"
#include "core/io/images/image_file.h"
#include "core/io/images/jpeg_codec.h"
#include "core/io/images/png_codec.h"

namespace plslam::robot {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 24, kHeight = 16;
const cv::Size kSize(kWidth, kHeight);

cv::Mat Colours() {
  cv::Mat bgr(kSize, CV_8UC3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      bgr.at<cv::Vec3b>(y, x) = {static_cast<uint8_t>(10 * x), static_cast<uint8_t>(15 * y),
                                 static_cast<uint8_t>(x * y)};
    }
  }
  return bgr;
}

/// Returns pixels with `padding` bytes after each row.
ForeignImage Raw(const std::string& encoding, const cv::Mat& pixels, int padding) {
  const auto row = static_cast<size_t>(pixels.cols) * pixels.elemSize();
  ForeignImage image;
  image.width_px = pixels.cols;
  image.height_px = pixels.rows;
  image.step_bytes = padding == 0 ? 0 : static_cast<int64_t>(row) + padding;
  image.encoding = encoding;
  for (int y = 0; y < pixels.rows; ++y) {
    image.bytes.insert(image.bytes.end(), pixels.ptr(y), pixels.ptr(y) + row);
    image.bytes.resize(image.bytes.size() + static_cast<size_t>(padding), 99);
  }
  return image;
}

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

TEST(ForeignImage, ColourPixelsBecomeTheGreyOfAFile) {
  const cv::Mat bgr = Colours();
  cv::Mat rgb(kSize, CV_8UC3);
  for (int i = 0; i < bgr.rows * bgr.cols; ++i) {
    const cv::Vec3b p = bgr.at<cv::Vec3b>(i);
    rgb.at<cv::Vec3b>(i) = {p[2], p[1], p[0]};
  }
  const cv::Mat grey = GreyPixels(bgr);
  for (const int padding : {0, 5}) {
    EXPECT_TRUE(Same(GreyOf(Raw("bgr8", bgr, padding), kSize, kWhiteOf16Bits), grey));
    EXPECT_TRUE(Same(GreyOf(Raw("rgb8", rgb, padding), kSize, kWhiteOf16Bits), grey));
    EXPECT_TRUE(Same(GreyOf(Raw("mono8", grey, padding), kSize, kWhiteOf16Bits), grey));
  }
}

TEST(ForeignImage, FilesAreJpegOrPng) {
  const cv::Mat grey = GreyPixels(Colours());
  const auto file = [](const std::string& content) {
    ForeignImage image;
    image.bytes.assign(content.begin(), content.end());
    return image;
  };
  EXPECT_TRUE(Same(GreyOf(file(EncodePng(grey)), kSize, kWhiteOf16Bits), grey));
  EXPECT_LT(cv::norm(GreyOf(file(EncodeJpeg(grey, 95)), kSize, kWhiteOf16Bits), grey, cv::NORM_INF), 12.0);
  EXPECT_THROW(GreyOf(file(EncodeJpeg(grey, 95)), {kWidth, kHeight + 1}, kWhiteOf16Bits), DatasetError);
  EXPECT_THROW(GreyOf(file("not a picture"), kSize, kWhiteOf16Bits), DatasetError);
  EXPECT_THROW(GreyOf(file(EncodeJpeg(grey, 95).substr(0, 200)), kSize, kWhiteOf16Bits), DatasetError);
}

TEST(ForeignImage, SizesThatLieAreRefused) {
  const ForeignImage good = Raw("mono8", GreyPixels(Colours()), 0);
  const auto complaint = [](const ForeignImage& image) -> std::string {
    try {
      GreyOf(image, kSize, kWhiteOf16Bits);
    } catch (const DatasetError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(complaint(good), "");
  ForeignImage image = good;
  image.width_px = 1 << 30;
  EXPECT_THAT(complaint(image), HasSubstr("1073741824 x 16 pixels instead of 24 x 16"));
  image = good;
  image.bytes.pop_back();
  EXPECT_THAT(complaint(image), HasSubstr("has 383 bytes in rows of 24"));
  for (const int64_t step : {int64_t{-24}, int64_t{23}, int64_t{1} << 31}) {
    image = good;
    image.step_bytes = step;
    EXPECT_NE(complaint(image), "") << step;
  }
  image = good;
  image.encoding = "yuv411";
  EXPECT_THAT(complaint(image), HasSubstr("'yuv411'"));
}

TEST(ForeignImage, PixelFormatsOfBotCore) {
  EXPECT_EQ(EncodingOfPixelFormat(1497715271), "mono8");
  EXPECT_EQ(EncodingOfPixelFormat(859981650), "rgb8");
  EXPECT_EQ(EncodingOfPixelFormat(861030210), "bgr8");
  EXPECT_EQ(EncodingOfPixelFormat(876758866), "rgba8");
  EXPECT_EQ(EncodingOfPixelFormat(877807426), "bgra8");
  EXPECT_EQ(EncodingOfPixelFormat(1196444237), "");
  EXPECT_EQ(EncodingOfPixelFormat(1498831189), "uyvy");
  EXPECT_EQ(EncodingOfPixelFormat(1448695129), "yuyv");
  EXPECT_EQ(EncodingOfPixelFormat(842094158), "nv12");
  EXPECT_EQ(EncodingOfPixelFormat(808596553), "i420");
  EXPECT_EQ(EncodingOfPixelFormat(842093913), "i420");
  EXPECT_EQ(EncodingOfPixelFormat(909199180), "mono16");
  EXPECT_EQ(EncodingOfPixelFormat(825770306), "bayer_bggr8");
  EXPECT_EQ(EncodingOfPixelFormat(878205016), "bayer_rggb8");
  EXPECT_EQ(EncodingOfPixelFormat(843137612), "bayer_gbrg16");
  EXPECT_THROW(EncodingOfPixelFormat(827677001), DatasetError);
}

}  // namespace
}  // namespace plslam::robot
