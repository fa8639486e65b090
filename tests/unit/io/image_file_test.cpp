// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/image_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "core/io/images/jpeg_codec.h"
#include "core/io/images/png_codec.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

using test::ErrorOf;
using testing::HasSubstr;

constexpr ImageSize kSize{300, 221};

std::string Pgm(const cv::Mat& image) {
  const bool wide = image.depth() == CV_16U;
  std::string bytes = fmt::format("P5\n{} {}\n{}\n", image.cols, image.rows, wide ? 65535 : 255);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const int value = wide ? image.at<uint16_t>(y, x) : image.at<uint8_t>(y, x);
      if (wide) bytes += static_cast<char>(value >> 8);
      bytes += static_cast<char>(value & 255);
    }
  }
  return bytes;
}

// Returns a PGM file of one row, with this largest value.
std::string PgmRow(int max_value, const std::vector<int>& values) {
  std::string bytes = fmt::format("P5\n{} 1\n{}\n", values.size(), max_value);
  for (const int value : values) {
    if (max_value > 255) bytes += static_cast<char>(value >> 8);
    bytes += static_cast<char>(value & 255);
  }
  return bytes;
}

class ImageFile : public testing::Test {
 protected:
  std::string Write(const std::string& name, const cv::Mat& image) {
    if (name.ends_with(".png")) return WriteBytes(name, EncodePng(image));
    return WriteBytes(name, name.ends_with(".pgm") ? Pgm(image) : EncodeJpeg(image, 95));
  }
  std::string WriteBytes(const std::string& name, const std::string& bytes) {
    test::WriteText(folder_.path() / name, bytes);
    return (folder_.path() / name).string();
  }
  test::TemporaryFolder folder_;
};

// Every 16-bit value, in a 256 x 256 image.
cv::Mat AllValues() {
  cv::Mat image(256, 256, CV_16UC1);
  for (int i = 0; i < 65536; ++i) image.at<uint16_t>(i / 256, i % 256) = static_cast<uint16_t>(i);
  return image;
}

// Cameras of 10 and 12 bits.
TEST_F(ImageFile, WhiteOfAPgmIsItsLargestValue) {
  for (const int max_value : {1, 100, 127, 255, 1023, 4095, 65535}) {
    const std::string path = WriteBytes("row.pgm", PgmRow(max_value, {0, max_value / 2, max_value}));
    const cv::Mat grey = ReadGreyImage(path, {3, 1});
    EXPECT_EQ(grey.at<uint8_t>(0, 0), 0) << max_value;
    EXPECT_NEAR(grey.at<uint8_t>(0, 1), 255.0 * (max_value / 2) / max_value, 1.0) << max_value;
    EXPECT_EQ(grey.at<uint8_t>(0, 2), 255) << max_value;
  }
  // Depth is no brightness.
  EXPECT_EQ(ReadDepthImage(WriteBytes("depth.pgm", PgmRow(4095, {0, 2000, 4000})), {3, 1}).at<uint16_t>(0, 1), 2000);
}

TEST_F(ImageFile, SixteenBitGreyIsScaledAndRounded) {
  for (const char* name : {"a.png", "a.pgm"}) {
    const cv::Mat grey = ReadGreyImage(Write(name, AllValues()), {256, 256});
    for (int i = 0; i < 65536; ++i) {
      ASSERT_EQ(grey.at<uint8_t>(i / 256, i % 256), std::lround(i * 255.0 / 65535.0)) << name << " value " << i;
    }
    EXPECT_EQ(cv::norm(ReadDepthImage(Write(name, AllValues()), {256, 256}), AllValues(), cv::NORM_INF), 0.0) << name;
  }
}

TEST_F(ImageFile, EveryFormatAndDepth) {
  const cv::Scalar grey(90, 90, 90, 255);
  for (const auto& [name, type] : {std::pair{"grey.png", CV_8UC1},
                                   {"colour.png", CV_8UC3},
                                   {"alpha.png", CV_8UC4},
                                   {"grey.jpg", CV_8UC1},
                                   {"grey.pgm", CV_8UC1}}) {
    const std::string path = Write(name, cv::Mat(221, 300, type, grey));
    EXPECT_EQ(ReadImageSize(path), kSize) << name;
    const cv::Mat image = ReadGreyImage(path, kSize);
    EXPECT_EQ(image.type(), CV_8UC1) << name;
    EXPECT_NEAR(cv::mean(image)[0], 90.0, 1.0) << name;
  }
  const std::string wide = Write("wide.png", cv::Mat(221, 300, CV_16UC3, cv::Scalar(25700, 25700, 25700)));
  EXPECT_EQ(ReadGreyImage(wide, kSize).at<uint8_t>(0, 0), 100);
}

TEST_F(ImageFile, TruncatedAnywhereIsRefused) {
  cv::Mat noise(24, 32, CV_8UC1);
  cv::RNG rng(5);
  rng.fill(noise, cv::RNG::UNIFORM, 0, 256);
  for (const char* name : {"n.png", "n.jpg", "n.pgm"}) {
    const std::string bytes = test::ReadText(Write(name, noise));
    // All lengths in the header and at the end, some in between.
    for (size_t n = 0; n < bytes.size(); n += n < 40 || n + 20 > bytes.size() ? 1 : 37) {
      const std::string path = WriteBytes(name, bytes.substr(0, n));
      EXPECT_THAT(ErrorOf([&] { ReadGreyImage(path, {32, 24}); }), HasSubstr(path)) << n << " of " << bytes.size();
    }
  }
}

TEST_F(ImageFile, DamagedPixelsOfAPngAreRefused) {
  std::string bytes = test::ReadText(Write("d.png", AllValues()));
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x10);
  const std::string path = WriteBytes("d.png", bytes);
  EXPECT_THAT(ErrorOf([&] { ReadGreyImage(path, {256, 256}); }), HasSubstr("cannot be decoded"));
}

TEST_F(ImageFile, DecodingErrorIsReported) {
  std::string png = EncodePng(AllValues());
  png[png.find("IDAT") + 4] = 0;
  EXPECT_THAT(ErrorOf([&] { ReadGreyImage(WriteBytes("d.png", png)); }),
              HasSubstr("d.png: the image is damaged and cannot be decoded: IDAT: "));
  std::string jpeg = EncodeJpeg(cv::Mat(24, 32, CV_8UC1, cv::Scalar(7)), 90);
  jpeg[jpeg.find("\xff\xc0") + 4] = 12;
  EXPECT_THAT(ErrorOf([&] { ReadGreyImage(WriteBytes("d.jpg", jpeg)); }),
              HasSubstr("Unsupported JPEG data precision 12"));
}

TEST_F(ImageFile, SizeIsCheckedBeforeDecoding) {
  const std::string path = WriteBytes("huge.pgm", "P5 60000 60000 255\n");
  EXPECT_THAT(ErrorOf([&] { ReadImageSize(path); }), HasSubstr("60000 x 60000 pixels"));
  EXPECT_THAT(ErrorOf([&] { ReadGreyImage(path, {60000, 60000}); }), HasSubstr("60000 x 60000 pixels"));
  const std::string claims = WriteBytes("claims.pgm", "P5 8000 8000 255\n");
  EXPECT_THAT(ErrorOf([&] { ReadGreyImage(claims, {8000, 8000}); }), HasSubstr("truncated"));
  EXPECT_THAT(ErrorOf([&] { ReadGreyImage(claims, kSize); }), HasSubstr("8000 x 8000 pixels instead of 300 x 221"));
  const std::string none = WriteBytes("none.pgm", "P5 0 10 255\n");
  EXPECT_THAT(ErrorOf([&] { ReadImageSize(none); }), HasSubstr("0 x 10"));
}

TEST_F(ImageFile, NoImageAtAll) {
  EXPECT_THAT(ErrorOf([&] { ReadGreyImage("/nowhere/a.png", kSize); }),
              HasSubstr("/nowhere/a.png: the image is missing"));
  EXPECT_THAT(ErrorOf([&] { ReadImageSize(folder_.path().string()); }), HasSubstr("is a folder, not a file"));
  const std::string text = WriteBytes("t.png", "not an image, but long enough to be one, honestly");
  EXPECT_THAT(ErrorOf([&] { ReadImageSize(text); }),
              HasSubstr("t.png: is not a PNG, JPEG or binary PGM image: it begins with 'not an i'"));
}

TEST_F(ImageFile, OtherFormatsAreNamed) {
  struct Row {
    std::string bytes;
    const char* what;
  };
  for (const Row& row :
       {Row{std::string("II*\0\x08\0\0\0", 8), "it seems to be a TIFF"}, Row{"BM6", "it seems to be a BMP"},
        Row{"GIF89a", "a GIF"}, Row{"P6 3 3 255\n", "a colour PPM"},
        Row{"version https://git-lfs.github.com/spec/v1\noid", "is a pointer of Git LFS, not the file itself"},
        Row{"<!DOCTYPE html>", "a page of HTML or XML, perhaps of a failed download"},
        Row{"\x1b[2J\xff", "it begins with '\\x1b[2J\\xff'"},
        Row{"\x89PNG", "its header is damaged or truncated (4 bytes)"}, Row{"", "the image is empty (0 bytes)"}}) {
    const std::string path = WriteBytes("t.png", row.bytes);
    EXPECT_THAT(ErrorOf([&] { ReadImageSize(path); }), HasSubstr(row.what));
  }
}

}  // namespace
}  // namespace plslam
