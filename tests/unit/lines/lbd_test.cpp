// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/lbd.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/unit/lines/rendered_edges.h"

namespace plslam {
namespace {

Gradients GradientsOf(const cv::Mat& image) {
  Gradients g;
  ComputeGradients(image, g);
  return g;
}

/// Texture with structure of several sizes: bars over noise.
cv::Mat Texture() {
  cv::Mat image = test::RenderBars({160, 160}, 90,
                                   {{{{20, 30}, {140, 60}}, 12, 180},
                                    {{{30, 120}, {130, 90}}, 8, 30},
                                    {{{80, 10}, {85, 150}}, 20, 140},
                                    {{{10, 80}, {150, 82}}, 5, 220}});
  test::AddNoise(image, 6, 11);
  return image;
}

/// The definition in floating point, sample by sample.
struct Twin {
  double rows[kLbdRows][kLbdChannels] = {};
  double mean[kLbdBands][kLbdChannels] = {};
  double variance[kLbdBands][kLbdChannels] = {};
};

Twin SlowLbd(const Gradients& g, const Segment2& s) {
  Twin twin;
  const double length = s.Length();
  const Eigen::Vector2d d = (s.q - s.p) / length;
  const Eigen::Vector2d n(-d.y(), d.x());
  const int count = std::clamp(static_cast<int>(length), 1, kLbdSamples);
  for (int r = 0; r < kLbdRows; ++r) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d at = s.p + (i + 0.5) / count * (s.q - s.p) + (r - kLbdRows / 2) * n;
      const int x = std::clamp(static_cast<int>(std::floor(at.x() + 0.5)), 0, g.dx.cols - 1);
      const int y = std::clamp(static_cast<int>(std::floor(at.y() + 0.5)), 0, g.dx.rows - 1);
      const Eigen::Vector2d gradient(g.dx.at<int16_t>(y, x), g.dy.at<int16_t>(y, x));
      const double parts[2] = {n.dot(gradient), d.dot(gradient)};
      for (int k = 0; k < 2; ++k) {
        twin.rows[r][2 * k] += std::max(parts[k], 0.0);
        twin.rows[r][2 * k + 1] += std::max(-parts[k], 0.0);
      }
    }
  }
  for (int band = 0; band < kLbdBands; ++band) {
    for (int c = 0; c < kLbdChannels; ++c) {
      double weights = 0, sum = 0, squares = 0;
      for (int r = 0; r < kLbdRows; ++r) {
        const double local = 1.5 * kLbdBandWidth + 0.5 - std::abs(r - (band + 0.5) * kLbdBandWidth + 0.5);
        if (local <= 0.0) continue;
        const double v = (kLbdRows - 1 - std::abs(r - kLbdRows / 2)) / 64.0 * twin.rows[r][c];
        weights += local;
        sum += local * v;
        squares += local * v * v;
      }
      twin.mean[band][c] = sum / weights;
      twin.variance[band][c] = squares / weights - sum / weights * (sum / weights);
    }
  }
  return twin;
}

TEST(Lbd, AgreesWithTheSlowTwin) {
  const Gradients g = GradientsOf(Texture());
  for (int k = 0; k < 24; ++k) {
    const Segment2 s = test::TurnedSegment({160, 160}, 0.1 + k * 2 * M_PI / 24, 55.0, 3.0);
    const Twin twin = SlowLbd(g, s);
    const auto bands = LbdBands(LbdRows(g, s));
    for (size_t b = 0; b < kLbdBands; ++b) {
      for (size_t c = 0; c < kLbdChannels; ++c) {
        // A few samples lie so near to a pixel's border that 16 fractional bits choose the other one.
        const double scale = std::abs(twin.mean[b][c]) + 200.0;
        EXPECT_NEAR(static_cast<double>(bands[b].mean[c]), twin.mean[b][c], 0.02 * scale) << k << " band " << b;
        const double variance_scale = twin.variance[b][c] + scale * scale;
        EXPECT_NEAR(static_cast<double>(bands[b].variance[c]), twin.variance[b][c], 0.02 * variance_scale) << k;
      }
    }
  }
}

TEST(Lbd, BitsCompareMeansAndVariancesOfBands) {
  std::array<LbdBand, kLbdBands> bands{};
  for (size_t b = 0; b < kLbdBands; ++b) bands[b].mean.fill(100 - static_cast<int64_t>(b));
  int set = 0;
  for (const uint64_t word : LbdBits(bands)) set += std::popcount(word);
  EXPECT_EQ(set, 36 * 4);
  for (size_t b = 0; b < kLbdBands; ++b) bands[b].variance.fill(100 - static_cast<int64_t>(b));
  set = 0;
  for (const uint64_t word : LbdBits(bands)) set += std::popcount(word);
  EXPECT_EQ(set, 256);
}

TEST(Lbd, IsTheSameInATurnedImage) {
  const cv::Mat image = Texture();
  cv::Mat turned;
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
  const Segment2 s = test::TurnedSegment({160, 160}, 0.4, 60.0, 0.0);
  const auto turn = [&](const Eigen::Vector2d& p) { return Eigen::Vector2d(image.rows - 1 - p.y(), p.x()); };
  const Descriptor a = ComputeLbd(GradientsOf(image), s);
  const Descriptor b = ComputeLbd(GradientsOf(turned), {turn(s.p), turn(s.q)});
  EXPECT_LE(HammingDistance(a, b), 6);
}

TEST(Lbd, InvariantToContrastNotToPosition) {
  const cv::Mat image = Texture();
  cv::Mat dim;
  image.convertTo(dim, -1, 0.5, 20);
  test::AddNoise(dim, 1.5, 4);
  const Segment2 s = test::TurnedSegment({160, 160}, 0.9, 60.0, 2.0);
  const Descriptor here = ComputeLbd(GradientsOf(image), s);
  EXPECT_LE(HammingDistance(here, ComputeLbd(GradientsOf(dim), s)), 30);
  const Segment2 elsewhere = test::TurnedSegment({160, 160}, 0.9, 60.0, 30.0);
  EXPECT_GE(HammingDistance(here, ComputeLbd(GradientsOf(image), elsewhere)), 60);
}

TEST(Lbd, AcceptsAnyImageAndSegment) {
  const Segment2 wild{{-300, 20}, {500, -40}};
  const Segment2 point{{3, 3}, {3, 3}};
  const Segment2 nan{{NAN, 0}, {1, 1}};
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(5, 40), cv::Size(64, 64)}) {
    const Gradients g = GradientsOf(test::NoiseImage(size, 128, 50, 1));
    EXPECT_EQ(ComputeLbd(g, wild), ComputeLbd(g, wild));
    EXPECT_EQ(ComputeLbd(g, point), Descriptor{});
    EXPECT_EQ(ComputeLbd(g, nan), Descriptor{});
  }
  EXPECT_EQ(ComputeLbd(Gradients(), wild), Descriptor{});
}

}  // namespace
}  // namespace plslam
