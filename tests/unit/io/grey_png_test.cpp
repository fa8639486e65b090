#include "core/io/grey_png.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <vector>

#include "core/io/png_filter.h"

namespace plslam {
namespace {

constexpr int64_t kMaxPixels = 1'000'000;

/// PNG 9.2 and 9.4 word by word.
std::vector<uint8_t> UndoneSlowly(std::vector<uint8_t> rows, size_t n_rows, size_t row_bytes, size_t pixel_bytes) {
  const size_t stride = row_bytes + 1;
  const auto at = [&](size_t y, size_t x, size_t up, size_t left) -> int {
    const bool outside = y < up || x < left * pixel_bytes;
    return outside ? 0 : rows[(y - up) * stride + 1 + x - left * pixel_bytes];
  };
  for (size_t y = 0; y < n_rows; ++y) {
    for (size_t x = 0; x < row_bytes; ++x) {
      const int a = at(y, x, 0, 1), b = at(y, x, 1, 0), c = at(y, x, 1, 1), p = a + b - c;
      const int pa = std::abs(p - a), pb = std::abs(p - b), pc = std::abs(p - c);
      const int paeth = pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
      const int prediction[] = {0, a, b, (a + b) / 2, paeth};
      uint8_t& byte = rows[y * stride + 1 + x];
      byte = static_cast<uint8_t>(byte + prediction[rows[y * stride]]);
    }
  }
  return rows;
}

/// Rows of noise. `share_of_paeth` of them use that filter, the others any.
std::vector<uint8_t> Noise(size_t n_rows, size_t row_bytes, double share_of_paeth, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<uint8_t> rows(n_rows * (row_bytes + 1));
  for (uint8_t& byte : rows) byte = static_cast<uint8_t>(random());
  for (size_t y = 0; y < n_rows; ++y) {
    const bool paeth = std::bernoulli_distribution(share_of_paeth)(random);
    rows[y * (row_bytes + 1)] = static_cast<uint8_t>(paeth ? 4 : random() % 5);
  }
  return rows;
}

TEST(PngFilter, AnyFiltersAsTheStandardSays) {
  for (const size_t row_bytes : {2UL, 4UL, 6UL, 8UL, 10UL, 64UL, 301UL * 2}) {
    for (const double share : {0.0, 0.9, 1.0}) {
      for (const size_t pixel_bytes : {1UL, 2UL}) {
        const size_t n_rows = 41;
        std::vector<uint8_t> rows = Noise(n_rows, row_bytes, share, static_cast<uint32_t>(row_bytes));
        const std::vector<uint8_t> expected = UndoneSlowly(rows, n_rows, row_bytes, pixel_bytes);
        ASSERT_TRUE(UndoPngFilters(rows, n_rows, row_bytes, pixel_bytes));
        EXPECT_EQ(rows, expected) << row_bytes << " bytes a row, " << share << " Paeth, pixel of " << pixel_bytes;
      }
    }
  }
}

TEST(PngFilter, EveryPredictionOfPaeth) {
  // Rows of a difference to the row above: with 8 rows and more this runs through the lanes, with 7 byte by byte.
  for (const size_t n_rows : {7UL, 33UL}) {
    for (int seed = 0; seed < 40; ++seed) {
      std::vector<uint8_t> rows = Noise(n_rows, 5000, 1.0, static_cast<uint32_t>(seed));
      const std::vector<uint8_t> expected = UndoneSlowly(rows, n_rows, 5000, 1);
      ASSERT_TRUE(UndoPngFilters(rows, n_rows, 5000, 1));
      ASSERT_EQ(rows, expected) << n_rows << " rows, seed " << seed;
    }
  }
}

TEST(PngFilter, UnknownFilterIsRefused) {
  std::vector<uint8_t> rows = Noise(12, 9, 0.5, 1);
  rows[11 * 10] = 5;
  EXPECT_FALSE(UndoPngFilters(rows, 12, 9, 1));
}

/// Noise above, a ramp below, so that an encoder chooses several filters.
cv::Mat Image(int type) {
  cv::Mat image(61, 83, type);
  cv::RNG rng(7);
  rng.fill(image, cv::RNG::UNIFORM, 0, type == CV_16UC1 ? 65536 : 256);
  for (int y = 20; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) image.col(x).row(y).setTo(3 * y + x);
  }
  return image;
}

std::vector<uint8_t> Encoded(const cv::Mat& image) {
  std::vector<uint8_t> bytes;
  cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 6});
  return bytes;
}

TEST(GreyPng, SamePixelsAsWereWritten) {
  for (const int type : {CV_8UC1, CV_16UC1}) {
    const cv::Mat image = Image(type);
    const auto decoded = DecodeGreyPng(Encoded(image), kMaxPixels);
    ASSERT_TRUE(decoded && decoded->type() == type && decoded->size() == image.size());
    EXPECT_EQ(cv::norm(*decoded, image, cv::NORM_INF), 0.0) << "type " << type;
  }
}

TEST(GreyPng, ColourIsForOthers) { EXPECT_FALSE(DecodeGreyPng(Encoded(cv::Mat(9, 9, CV_8UC3)), kMaxPixels)); }

TEST(GreyPng, TooManyPixelsAreRefused) {
  const std::vector<uint8_t> bytes = Encoded(Image(CV_8UC1));
  EXPECT_TRUE(DecodeGreyPng(bytes, 61 * 83));
  EXPECT_FALSE(DecodeGreyPng(bytes, 61 * 83 - 1));
}

TEST(GreyPng, DamagedAnywhereIsRefusedOrHarmless) {
  const cv::Mat image = Image(CV_8UC1);
  const std::vector<uint8_t> bytes = Encoded(image);
  for (size_t i = 0; i < bytes.size(); ++i) {
    std::vector<uint8_t> damaged = bytes;
    damaged[i] ^= 0x21;
    const auto decoded = DecodeGreyPng(damaged, kMaxPixels);
    EXPECT_FALSE(decoded && cv::norm(*decoded, image, cv::NORM_INF) > 0.0) << "byte " << i;
    EXPECT_FALSE(DecodeGreyPng(std::span(bytes).first(i), kMaxPixels)) << "first " << i << " bytes";
  }
}

}  // namespace
}  // namespace plslam
