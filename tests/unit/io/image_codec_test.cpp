// SPDX-License-Identifier: BSD-3-Clause
// Our decoders and encoders beside those of OpenCV's imgcodecs: the same pixels, and the same files.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "core/io/images/image_file.h"
#include "core/io/images/image_header.h"
#include "core/io/images/jpeg_codec.h"
#include "core/io/images/png_codec.h"
#include "tests/support/data_folder.h"
#include "tests/support/long_tests.h"
#include "tests/support/text_file.h"
#include "tests/unit/io/jpeg_kinds.h"
#include "tests/unit/io/png_kinds.h"

namespace plslam {
namespace {

constexpr int kJpegFlags = cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION;

std::span<const uint8_t> BytesOf(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

cv::Mat DecodedByOpenCv(const std::string& file, int flags) {
  return cv::imdecode(std::vector<uchar>(file.begin(), file.end()), flags);
}

cv::Mat Decoded(const std::string& file) {
  const auto header = ParseImageHeader(BytesOf(file));
  if (!header) throw std::runtime_error("no header");
  const cv::Size size(static_cast<int>(header->width_px), static_cast<int>(header->height_px));
  return header->format == ImageFormat::kPng ? DecodePng(BytesOf(file), size) : DecodeJpeg(BytesOf(file), size);
}

testing::AssertionResult AreTheSame(const cv::Mat& a, const cv::Mat& b) {
  if (a.type() != b.type() || a.size() != b.size()) {
    return testing::AssertionFailure() << a.size() << " of type " << a.type() << " and " << b.size() << " of type "
                                       << b.type();
  }
  const double apart = cv::norm(a, b, cv::NORM_INF);
  if (apart == 0.0) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "pixels are up to " << apart << " apart";
}

cv::Mat Noise(int type, cv::Size size) {
  cv::Mat image(size, type);
  cv::RNG random(17);
  random.fill(image, cv::RNG::UNIFORM, 0, image.depth() == CV_16U ? 65536 : 256);
  cv::GaussianBlur(image, image, {5, 5}, 1.2);
  return image;
}

TEST(PngCodec, PixelsOfEveryFormatEqualOpenCv) {
  unsigned seed = 0;
  for (const test::PngKind& kind : test::AllPngKinds()) {
    const std::string file = test::MakePng(kind, ++seed);
    EXPECT_TRUE(AreTheSame(Decoded(file), DecodedByOpenCv(file, cv::IMREAD_UNCHANGED))) << kind.Name();
  }
  EXPECT_GT(seed, 150U);
}

TEST(PngCodec, FilesEqualOpenCv) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4}) {
    const cv::Mat image = Noise(type, {61, 40});
    const cv::Mat part = image(cv::Rect(3, 2, 50, 31));
    std::vector<uchar> file;
    cv::imencode(".png", image, file);
    EXPECT_EQ(EncodePng(image), std::string(file.begin(), file.end())) << type;
    cv::imencode(".png", part, file);
    EXPECT_EQ(EncodePng(part), std::string(file.begin(), file.end())) << type << ", a part";
    for (const int level : {0, 1, 3, 9}) {
      cv::imencode(".png", image, file, {cv::IMWRITE_PNG_COMPRESSION, level});
      EXPECT_EQ(EncodePng(image, level), std::string(file.begin(), file.end())) << type << " at " << level;
    }
    EXPECT_TRUE(AreTheSame(Decoded(EncodePng(image)), image));
  }
  EXPECT_THROW(EncodePng(cv::Mat()), std::invalid_argument);
  EXPECT_THROW(EncodePng(cv::Mat(4, 4, CV_32FC1)), std::invalid_argument);
  EXPECT_THROW(EncodePng(cv::Mat(4, 4, CV_8UC2)), std::invalid_argument);
}

TEST(JpegCodec, LumaOfEveryFormatEqualsOpenCv) {
  for (const test::JpegKind& kind : test::AllJpegKinds()) {
    for (const cv::Size size : {cv::Size(75, 49), cv::Size(64, 32), cv::Size(1, 1)}) {
      const std::string file = test::MakeJpeg(kind, size.width, size.height, 3);
      EXPECT_TRUE(AreTheSame(Decoded(file), DecodedByOpenCv(file, kJpegFlags))) << kind.name << " " << size;
    }
  }
}

TEST(JpegCodec, FilesEqualOpenCv) {
  for (const cv::Size size : {cv::Size(120, 77), cv::Size(1, 1), cv::Size(512, 300)}) {
    const cv::Mat image = Noise(CV_8UC1, size);
    for (const int quality : {0, 68, 95, 100}) {
      std::vector<uchar> file;
      cv::imencode(".jpg", image, file, {cv::IMWRITE_JPEG_QUALITY, quality});
      EXPECT_EQ(EncodeJpeg(image, quality), std::string(file.begin(), file.end())) << size << " at " << quality;
    }
  }
  EXPECT_THROW(EncodeJpeg(cv::Mat(), 90), std::invalid_argument);
  EXPECT_THROW(EncodeJpeg(cv::Mat(4, 4, CV_8UC3), 90), std::invalid_argument);
  EXPECT_THROW(EncodeJpeg(cv::Mat(1, 65501, CV_8UC1), 90), std::invalid_argument);
}

// The whole picture again for each scan of a few bytes: 100,000 of them would take an hour.
TEST(JpegCodec, ScansWithoutEndAreRefused) {
  std::string file = test::MakeJpeg({.name = "", .progressive = true}, 64, 64, 1);
  const size_t end = file.rfind("\xff\xd9");
  const size_t scan = file.rfind("\xff\xda");
  const std::string last = file.substr(scan, end - scan);
  for (int i = 0; i < 600; ++i) file.insert(end, last);
  EXPECT_THAT([&] { Decoded(file); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("more than 500 scans")));
}

/// Returns a copy with one to three changed bytes, or truncated.
std::string Damaged(const std::string& file, std::mt19937& random) {
  std::string damaged = file;
  for (size_t n = random() % 3 + 1; n > 0; --n)
    damaged[random() % damaged.size()] = static_cast<char>(random() & 255U);
  if (random() % 8 == 0) damaged.resize(random() % damaged.size());
  return damaged;
}

/// Damaged files are rejected or decoded as by OpenCV; returns the number of files that were not rejected.
int ReadDamaged(const std::string& file, int flags, int n, std::mt19937& random) {
  int n_read = 0;
  for (int i = 0; i < n; ++i) {
    const std::string damaged = Damaged(file, random);
    const auto header = ParseImageHeader(BytesOf(damaged));
    if (!header || std::max(header->width_px, header->height_px) > 1000) continue;
    cv::Mat image;
    try {
      image = Decoded(damaged);
    } catch (const std::runtime_error& e) {
      EXPECT_STRNE(e.what(), "");
      continue;
    }
    ++n_read;
    EXPECT_TRUE(AreTheSame(image, DecodedByOpenCv(damaged, flags)));
  }
  return n_read;
}

TEST(ImageCodecs, DamagedFilesAreRefusedOrReadAsOpenCvReadsThem) {
  std::mt19937 random(23);
  int n_png = 0;
  int n_jpeg = 0;
  for (const test::PngKind& kind : test::AllPngKinds()) {
    n_png += ReadDamaged(test::MakePng(kind, 5), cv::IMREAD_UNCHANGED, 4, random);
  }
  for (const test::JpegKind& kind : test::AllJpegKinds()) {
    n_jpeg += ReadDamaged(test::MakeJpeg(kind, 45, 31, 5), kJpegFlags, 40, random);
  }
  // In check sums of metadata; in pixels of JPEGs, which have none.
  EXPECT_GT(n_png, 0);
  EXPECT_GT(n_jpeg, 200);
}

/// Decodes a real image by OpenCV, the reference of the program's own decoders.
cv::Mat GreyByOpenCv(const std::filesystem::path& path) {
  const std::string file = ReadText(path);
  if (path.extension() != ".png") return DecodedByOpenCv(file, kJpegFlags);
  cv::Mat image = DecodedByOpenCv(file, cv::IMREAD_UNCHANGED);
  if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
  if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_BGRA2GRAY);
  return image;
}

TEST(ImageCodecs, RealImagesAreReadAsOpenCvReadsThem) {
  PLSLAM_REQUIRE_DATA(kitti, "kitti_03");
  std::vector<std::filesystem::path> images;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kitti.parent_path())) {
    const auto type = entry.path().extension();
    if (type == ".png" || type == ".jpg" || type == ".jpeg") images.push_back(entry.path());
  }
  std::sort(images.begin(), images.end());
  ASSERT_GT(images.size(), 100U);
  const size_t stride = test::LongTests() ? 1 : 23;
  for (size_t i = 0; i < images.size(); i += stride) {
    const cv::Mat expected = GreyByOpenCv(images[i]);
    const ImageSize size = ReadImageSize(images[i]);
    const bool wide = expected.depth() == CV_16U;
    EXPECT_TRUE(AreTheSame(wide ? ReadDepthImage(images[i], size) : ReadGreyImage(images[i]), expected)) << images[i];
  }
}

}  // namespace
}  // namespace plslam
