// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/png_grey.h"

#include <gmock/gmock.h>
#include <png.h>

#include <array>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <random>

#include "core/io/images/png_codec.h"
#include "tests/unit/io/png_kinds.h"

namespace plslam {
namespace {

std::span<const uint8_t> BytesOf(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

/// Exactly as in the standard.
int PaethOfTheStandard(int left, int above, int above_left) {
  const int p = left + above - above_left;
  const int to_left = std::abs(p - left);
  const int to_above = std::abs(p - above);
  const int to_corner = std::abs(p - above_left);
  if (to_left <= to_above && to_left <= to_corner) return left;
  return to_above <= to_corner ? above : above_left;
}

cv::Mat UnfilteredPixelByPixel(const std::vector<uint8_t>& filtered, cv::Size size) {
  cv::Mat out(size, CV_8UC1);
  const uint8_t* in = filtered.data();
  for (int y = 0; y < size.height; ++y) {
    const int filter = *in++;
    for (int x = 0; x < size.width; ++x) {
      const int left = x > 0 ? out.at<uint8_t>(y, x - 1) : 0;
      const int above = y > 0 ? out.at<uint8_t>(y - 1, x) : 0;
      const int corner = x > 0 && y > 0 ? out.at<uint8_t>(y - 1, x - 1) : 0;
      const std::array<int, 5> predicted = {0, left, above, (left + above) / 2,
                                            PaethOfTheStandard(left, above, corner)};
      out.at<uint8_t>(y, x) = static_cast<uint8_t>(*in++ + predicted[static_cast<size_t>(filter)]);
    }
  }
  return out;
}

/// The filter of a row is given or, below 0, any.
std::vector<uint8_t> RandomRows(cv::Size size, int filter, std::mt19937& random) {
  std::vector<uint8_t> rows;
  for (int y = 0; y < size.height; ++y) {
    rows.push_back(static_cast<uint8_t>(filter < 0 ? random() % 5 : static_cast<unsigned>(filter)));
    for (int x = 0; x < size.width; ++x) rows.push_back(static_cast<uint8_t>(random()));
  }
  return rows;
}

TEST(PngFilters, RowsEqualTheStandardPixelByPixel) {
  std::mt19937 random(5);
  for (const int width : {1, 2, 7, 8, 9, 16, 33, 301}) {
    for (const int height : {1, 2, 7, 8, 9, 20}) {
      for (const int filter : {-1, 0, 1, 2, 3, 4}) {
        const cv::Size size(width, height);
        const std::vector<uint8_t> rows = RandomRows(size, filter, random);
        cv::Mat found(size, CV_8UC1);
        ASSERT_TRUE(TakeFiltersOff(rows.data(), found));
        EXPECT_EQ(cv::norm(found, UnfilteredPixelByPixel(rows, size), cv::NORM_INF), 0.0) << size << " " << filter;
      }
    }
  }
}

TEST(PngFilters, PaethPredictionForAllNeighbours) {
  // Two rows and two columns: the last pixel has any given neighbours, and a difference of 0.
  std::vector<uint8_t> rows = {0, 0, 0, 4, 0, 0};
  cv::Mat found(2, 2, CV_8UC1);
  for (int corner = 0; corner < 256; corner += 3) {
    for (int above = 0; above < 256; above += 5) {
      for (int left = 0; left < 256; ++left) {
        rows[1] = static_cast<uint8_t>(corner);
        rows[2] = static_cast<uint8_t>(above);
        rows[4] = static_cast<uint8_t>(left - PaethOfTheStandard(0, corner, 0));
        ASSERT_TRUE(TakeFiltersOff(rows.data(), found));
        ASSERT_EQ(found.at<uint8_t>(1, 1), PaethOfTheStandard(left, above, corner))
            << left << " " << above << " " << corner;
      }
    }
  }
}

TEST(PngFilters, UnknownFilterNumberIsRefused) {
  cv::Mat out(1, 3, CV_8UC1);
  const std::vector<uint8_t> row = {5, 1, 2, 3};
  EXPECT_FALSE(TakeFiltersOff(row.data(), out));
}

TEST(GreyPng, IsForEightBitsOfGreyAlone) {
  for (const test::PngKind& kind : test::AllPngKinds()) {
    const bool is_plain =
        kind.colour_type == PNG_COLOR_TYPE_GRAY && kind.bits == 8 && !kind.interlaced && !kind.transparent_colour;
    const std::string file = test::MakePng(kind, 7);
    EXPECT_EQ(DecodeGreyPng(BytesOf(file), {kind.width_px, kind.height_px}).has_value(), is_plain) << kind.Name();
  }
}

TEST(GreyPng, LeavesEveryDamagedFileToLibpng) {
  cv::Mat image(40, 61, CV_8UC1);
  cv::RNG(3).fill(image, cv::RNG::UNIFORM, 0, 256);
  const std::string whole = EncodePng(image, 6);
  ASSERT_TRUE(DecodeGreyPng(BytesOf(whole), image.size()));
  for (size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    EXPECT_FALSE(DecodeGreyPng(BytesOf(damaged), image.size())) << "byte " << i;
    EXPECT_FALSE(DecodeGreyPng(BytesOf(whole.substr(0, i)), image.size())) << "cut off after " << i;
  }
  EXPECT_FALSE(DecodeGreyPng(BytesOf(whole), {61, 41}));
}

}  // namespace
}  // namespace plslam
