// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/patch_aligner.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/features/texture.h"

namespace plslam::vo {
namespace {

constexpr int kPairWidth = 260;
constexpr int kPairHeight = 120;

struct ShiftErrors {
  int tried = 0;
  std::vector<double> error_px;
  std::vector<double> normalised;

  double Rms(const std::vector<double>& v) const {
    double sum = 0.0;
    for (const double e : v) sum += e * e;
    return std::sqrt(sum / static_cast<double>(v.size()));
  }
};

/// Aligns a grid of patches, each from a start that is wrong by about a pixel.
ShiftErrors AlignAll(const test::View& left_view, const test::View& right_view, double scale = 1.0,
                     double softness = 1.0, double sigma_row_px = 0.3) {
  const cv::Mat left = test::RenderTexture(kPairWidth, kPairHeight, left_view, 3, softness);
  const cv::Mat right = test::RenderTexture(kPairWidth, kPairHeight, right_view, 3, softness);
  const HalvedPair pair(left, right);
  const PatchAligner aligner(pair, sigma_row_px);
  const double truth = right_view.shift_x_px - left_view.shift_x_px;
  ShiftErrors errors;
  for (int v = 30; v < kPairHeight - 30; v += 6) {
    for (int u = 60; u < kPairWidth - 40; u += 7) {
      ++errors.tried;
      const double start = truth + 0.8 * scale * ((u + v) % 2 == 0 ? 1.0 : -1.0);
      const auto found = aligner.Align({u + 0.3, v - 0.2}, scale, start);
      if (!found || found->correlation < 0.8) continue;
      errors.error_px.push_back(found->disparity_px - truth);
      errors.normalised.push_back((found->disparity_px - truth) / found->sigma_disparity_px);
    }
  }
  return errors;
}

TEST(PatchAligner, SubPixelDisparityOfACleanPair) {
  for (const double disparity : {20.0, 20.25, 20.5, 31.8}) {
    const ShiftErrors e = AlignAll({}, {.shift_x_px = disparity});
    EXPECT_GT(e.error_px.size(), 0.9 * e.tried) << disparity;
    EXPECT_LT(e.Rms(e.error_px), 0.03) << disparity;
  }
}

TEST(PatchAligner, TwiceTheExposureOnOneSide) {
  const ShiftErrors e = AlignAll({.gain = 0.5}, {.shift_x_px = 14.4, .gain = 1.0, .offset = 10.0});
  EXPECT_GT(e.error_px.size(), 0.9 * e.tried);
  EXPECT_LT(e.Rms(e.error_px), 0.05);
}

TEST(PatchAligner, SigmaIsTheErrorUnderNoise) {
  for (const double noise : {4.0, 10.0}) {
    const ShiftErrors e =
        AlignAll({.noise = noise, .noise_seed = 1}, {.shift_x_px = 17.6, .noise = noise, .noise_seed = 2}, 1.0, 2.0);
    EXPECT_GT(e.error_px.size(), 0.5 * e.tried);
    EXPECT_GT(e.Rms(e.normalised), 0.6) << "noise " << noise << ", rms " << e.Rms(e.error_px) << " px";
    EXPECT_LT(e.Rms(e.normalised), 1.4) << "noise " << noise << ", rms " << e.Rms(e.error_px) << " px";
  }
}

TEST(PatchAligner, RowErrorWithinThePriorDoesNotBecomeDisparity) {
  const ShiftErrors e = AlignAll({}, {.shift_x_px = 12.3, .shift_y_px = 0.4}, 1.0, 1.5);
  EXPECT_GT(e.error_px.size(), 0.9 * e.tried);
  EXPECT_LT(e.Rms(e.error_px), 0.06);
}

TEST(PatchAligner, CoarseFeaturesUseHalvedImages) {
  for (const double scale : {2.0, 3.6}) {
    const ShiftErrors e = AlignAll({}, {.shift_x_px = 21.7}, scale, 3.0);
    EXPECT_GT(e.error_px.size(), 0.3 * e.tried) << scale;
    EXPECT_LT(e.Rms(e.error_px), 0.05 * scale) << scale;
  }
}

TEST(PatchAligner, StripesAlongTheRowAreRefused) {
  cv::Mat stripes(80, 120, CV_8UC1);
  for (int y = 0; y < 80; ++y) stripes.row(y).setTo(y % 12 < 6 ? 60 : 180);
  const HalvedPair pair(stripes, stripes);
  EXPECT_FALSE(PatchAligner(pair, 0.3).Align({60, 40}, 1.0, 0.0));
}

TEST(PatchAligner, FlatBorderTinyAndFarOffStartsGiveNothing) {
  const cv::Mat flat(80, 120, CV_8UC1, cv::Scalar(90));
  const HalvedPair flat_pair(flat, flat);
  EXPECT_FALSE(PatchAligner(flat_pair, 0.3).Align({60, 40}, 1.0, 5.0));
  const cv::Mat image = test::RandomImage(80, 60, 1);
  const HalvedPair pair(image, image);
  const PatchAligner aligner(pair, 0.3);
  EXPECT_FALSE(aligner.Align({3, 30}, 1.0, 0.0));
  EXPECT_FALSE(aligner.Align({40, 58}, 1.0, 0.0));
  EXPECT_FALSE(aligner.Align({40, 30}, 1.0, 60.0));
  const cv::Mat pixel(1, 1, CV_8UC1, cv::Scalar(5));
  const HalvedPair tiny(pixel, pixel);
  EXPECT_FALSE(PatchAligner(tiny, 0.3).Align({0, 0}, 4.0, 0.0));
}

}  // namespace
}  // namespace plslam::vo
