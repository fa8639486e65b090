// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/line_stereo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/features/lines/line_extractor.h"
#include "core/features/lines/line_sigma.h"
#include "tests/unit/lines/rendered_edges.h"

namespace plslam::vo {
namespace {

const cv::Size kSize(200, 140);

struct Pair {
  cv::Mat left;
  cv::Mat right;
};

/// A bar that seems shifted, and turned, by its disparities at p and q.
Pair RenderPair(const test::Bar& bar, double disparity_p, double disparity_q, double noise, uint32_t seed) {
  test::Bar right = bar;
  right.axis.p.x() -= disparity_p;
  right.axis.q.x() -= disparity_q;
  Pair pair{test::RenderBars(kSize, 80, {bar}), test::RenderBars(kSize, 80, {right})};
  if (noise > 0.0) test::AddNoise(pair.left, noise, 2 * seed);
  if (noise > 0.0) test::AddNoise(pair.right, noise, 2 * seed + 1);
  return pair;
}

std::vector<StereoLine> Match(const Pair& pair, const StereoOptions& options = StereoOptions()) {
  LineExtractor extractor{LineOptions()};
  std::vector<StereoLine> lines = WithoutDepth(extractor.Extract(pair.left));
  MatchLinesStereo(lines, extractor.Extract(pair.right), pair.left, pair.right, RowField(), options);
  return lines;
}

test::Bar SteepBar(double lean, double x) { return {{{100 + x, 20}, {100 + x + lean, 120}}, 16, 150}; }

TEST(LineStereo, ConstantDisparityIsExact) {
  const auto lines = Match(RenderPair(SteepBar(12.3, 0.2), 23.4, 23.4, 0, 0));
  int with_depth = 0;
  for (const StereoLine& l : lines) {
    if (!l.HasDepth()) continue;
    ++with_depth;
    EXPECT_NEAR(l.disparity_p_px, 23.4, 0.06);
    EXPECT_NEAR(l.disparity_q_px, 23.4, 0.06);
  }
  EXPECT_EQ(with_depth, 2);
}

TEST(LineStereo, NormalisedErrorsAreAboutOne) {
  double squares = 0.0;
  int count = 0;
  for (uint32_t i = 0; i < 40; ++i) {
    const double d = 12.0 + 0.317 * i;
    test::Bar bar = SteepBar(2.0 * i - 40.0, 0.13 * i);
    bar.grey = 95;  // contrast 15, so that noise, not sampling, makes the error
    for (const StereoLine& l : Match(RenderPair(bar, d, d, 2.0, i))) {
      if (!l.HasDepth()) continue;
      squares += std::pow((l.disparity_p_px - d) / l.sigma_disparity_p_px, 2);
      squares += std::pow((l.disparity_q_px - d) / l.sigma_disparity_q_px, 2);
      count += 2;
    }
  }
  ASSERT_GE(count, 80);
  const double normalised = std::sqrt(squares / count);
  EXPECT_GT(normalised, 0.7) << count << " disparities";
  EXPECT_LT(normalised, 1.3) << count << " disparities";
}

TEST(LineStereo, SlantedInDepthGivesTwoDisparities) {
  const Pair pair = RenderPair(SteepBar(0.4, 0.0), 10.0, 20.0, 1.0, 3);
  int with_depth = 0;
  for (const StereoLine& l : Match(pair)) {
    if (!l.HasDepth()) continue;
    ++with_depth;
    const auto expected = [](double v) { return 10.0 + 10.0 * (v - 20.0) / 100.0; };
    EXPECT_NEAR(l.disparity_p_px, expected(l.left.segment.p.y()), 0.15);
    EXPECT_NEAR(l.disparity_q_px, expected(l.left.segment.q.y()), 0.15);
  }
  EXPECT_EQ(with_depth, 2);
}

TEST(LineStereo, SegmentParallelToBaselineHasNoDepth) {
  for (const double rise : {0.0, 4.0, -10.0}) {
    const test::Bar bar{{{50, 70}, {170, 70 + rise}}, 30, 160};
    const auto lines = Match(RenderPair(bar, 15, 15, 1.0, 1));
    int flat = 0;
    for (const StereoLine& l : lines) {
      const Eigen::Vector2d step = l.left.segment.q - l.left.segment.p;
      if (std::abs(step.y()) > std::abs(step.x())) continue;
      ++flat;
      EXPECT_FALSE(l.HasDepth()) << "rise " << rise;
      EXPECT_LT(l.disparity_p_px, 0.0);
      EXPECT_GT(l.sigma_px, 0.0);
    }
    EXPECT_EQ(flat, 2) << "rise " << rise;
  }
}

/// One left and one right line, to test each gate separately. Without images: appearance is not used.
struct OneToOne {
  StereoLine left;
  LineFeature right;
  bool Matches(const StereoOptions& options = StereoOptions()) const {
    std::vector<StereoLine> lines = {left};
    MatchLinesStereo(lines, {right}, cv::Mat(), cv::Mat(), RowField(), options);
    return lines[0].HasDepth();
  }
};

OneToOne Agreeing() {
  OneToOne pair;
  pair.left.left.segment = {{100, 20}, {105, 80}};
  pair.left.left.response = 40;
  pair.right.segment = {{80, 20}, {85, 80}};
  pair.right.response = 40;
  return pair;
}

TEST(LineStereo, EachGateRejectsAlone) {
  EXPECT_TRUE(Agreeing().Matches());
  OneToOne other = Agreeing();
  other.right.segment = {{85, 80}, {80, 20}};
  EXPECT_FALSE(other.Matches()) << "polarity";
  other = Agreeing();
  other.right.segment = {{120, 20}, {125, 80}};
  EXPECT_FALSE(other.Matches()) << "disparity is negative";
  other = Agreeing();
  other.right.segment = {{99, 20}, {60, 80}};
  EXPECT_FALSE(other.Matches()) << "direction";
  other = Agreeing();
  other.right.segment = {{80, 70}, {85, 130}};
  EXPECT_FALSE(other.Matches()) << "shared rows";
  other = Agreeing();
  other.right.segment = {{82, 50}, {83, 62}};
  EXPECT_FALSE(other.Matches()) << "length";
  other = Agreeing();
  other.right.descriptor.fill(0x0f0f0f0f0f0f0f0fULL);
  EXPECT_FALSE(other.Matches()) << "descriptor";
  other = Agreeing();
  other.right.segment = {{97, 20}, {84, 80}};
  EXPECT_FALSE(other.Matches()) << "ratio of end disparities";
  StereoOptions near;
  near.max_disparity_px = 15.0;
  EXPECT_FALSE(Agreeing().Matches(near)) << "disparity too large";
  StereoOptions strict;
  strict.line_max_sigma_disparity_px = 0.01;
  EXPECT_FALSE(Agreeing().Matches(strict)) << "uncertainty";
}

TEST(LineStereo, ExtrapolationCostsCertainty) {
  OneToOne whole = Agreeing();
  OneToOne part = Agreeing();
  part.right.segment = {{80, 20}, {82.5, 50}};
  std::vector<StereoLine> a = {whole.left};
  std::vector<StereoLine> b = {part.left};
  MatchLinesStereo(a, {whole.right}, cv::Mat(), cv::Mat(), RowField(), StereoOptions());
  MatchLinesStereo(b, {part.right}, cv::Mat(), cv::Mat(), RowField(), StereoOptions());
  ASSERT_TRUE(b[0].HasDepth());
  EXPECT_NEAR(b[0].disparity_q_px, 20.0, 1e-9) << "on the infinite line";
  EXPECT_GT(b[0].sigma_disparity_q_px, 2.0 * a[0].sigma_disparity_q_px);
  EXPECT_LT(b[0].sigma_disparity_p_px, b[0].sigma_disparity_q_px);
}

TEST(LineStereo, TwoAlikeAtDifferentDisparitiesGiveNone) {
  OneToOne pair = Agreeing();
  pair.right.descriptor[0] = 0xff;
  LineFeature twin = pair.right;
  twin.segment.p.x() -= 12;
  twin.segment.q.x() -= 12;
  std::vector<StereoLine> lines = {pair.left};
  MatchLinesStereo(lines, {pair.right, twin}, cv::Mat(), cv::Mat(), RowField(), StereoOptions());
  EXPECT_FALSE(lines[0].HasDepth());
  // A piece of the same edge is no rival.
  twin.segment = {{82.5, 50}, {85, 80}};
  MatchLinesStereo(lines, {pair.right, twin}, cv::Mat(), cv::Mat(), RowField(), StereoOptions());
  EXPECT_TRUE(lines[0].HasDepth());
}

TEST(LineStereo, UnlikeImagesRefuseTheMatch) {
  const Pair pair = RenderPair(SteepBar(8, 0), 20, 20, 1.0, 9);
  LineExtractor extractor{LineOptions()};
  std::vector<StereoLine> lines = WithoutDepth(extractor.Extract(pair.left));
  const cv::Mat other = test::NoiseImage(kSize, 128, 40, 8);
  MatchLinesStereo(lines, extractor.Extract(pair.right), pair.left, other, RowField(), StereoOptions());
  for (const StereoLine& l : lines) EXPECT_FALSE(l.HasDepth());
}

// Dirt on the right lens hides a third of the bar, and changes the descriptors of its edges.
TEST(LineStereo, DirtOnALineIsLeftOut) {
  Pair pair = RenderPair(SteepBar(8, 0), 20, 20, 1.0, 9);
  LineExtractor extractor{LineOptions()};
  const std::vector<StereoLine> left = WithoutDepth(extractor.Extract(pair.left));
  std::vector<LineFeature> right = extractor.Extract(pair.right);
  for (LineFeature& line : right) line.descriptor.fill(0x5555555555555555ULL);
  pair.right.rowRange(56, 88).setTo(20);
  PairDirt dirt;
  const int columns = kSize.width / DirtCells::kCell_px + 1;
  std::vector<char> cells(static_cast<size_t>(columns) * 20, 0);
  for (int i = 7 * columns; i < 11 * columns; ++i) cells[static_cast<size_t>(i)] = 1;
  dirt.right = DirtCells(cells, columns);
  const auto with_depth = [&](const PairDirt& known) {
    std::vector<StereoLine> lines = left;
    MatchLinesStereo(lines, right, pair.left, pair.right, RowField(), StereoOptions(), known);
    return std::count_if(lines.begin(), lines.end(), [](const StereoLine& l) {
      return l.HasDepth() && std::abs(l.disparity_p_px - 20.0) < 0.5 && std::abs(l.disparity_q_px - 20.0) < 0.5;
    });
  };
  EXPECT_EQ(with_depth({}), 0);
  EXPECT_EQ(with_depth(dirt), 2);
}

TEST(LineStereo, IdenticalImagesHaveNoDepth) {
  // Disparity zero is at infinity: below the smallest disparity.
  const cv::Mat image = RenderPair(SteepBar(8, 0), 20, 20, 1.0, 9).left;
  for (const StereoLine& l : Match({image, image})) EXPECT_FALSE(l.HasDepth());
}

TEST(LineStereo, NoneOneAndDegenerateLines) {
  std::vector<StereoLine> none;
  MatchLinesStereo(none, {}, cv::Mat(), cv::Mat(), RowField(), StereoOptions());
  EXPECT_TRUE(none.empty());
  std::vector<StereoLine> one(1);
  MatchLinesStereo(one, {}, cv::Mat(), cv::Mat(), RowField(), StereoOptions());
  MatchLinesStereo(one, {LineFeature()}, cv::Mat(), cv::Mat(), RowField(), StereoOptions());
  EXPECT_FALSE(one[0].HasDepth());
  one[0].left.segment = {{NAN, 0}, {10, 20}};
  MatchLinesStereo(one, {Agreeing().right}, cv::Mat(), cv::Mat(), RowField(), StereoOptions());
  EXPECT_FALSE(one[0].HasDepth());
}

TEST(LineSigma, GrowsOutwardsAndShrinksWithLengthAndContrast) {
  EXPECT_NEAR(LineSigma_px(50, 20, 1.0), 2.0 * LineSigma_px(50, 20, 0.0), 1e-12);
  EXPECT_GT(LineSigma_px(50, 20, 3.0), LineSigma_px(50, 20, 1.0));
  EXPECT_GT(LineSigma_px(20, 20, 1.0), LineSigma_px(80, 20, 1.0));
  EXPECT_GT(LineSigma_px(50, 10, 1.0), LineSigma_px(50, 40, 1.0));
  EXPECT_NEAR(PlaceAlong({{0, 0}, {10, 0}}, {20, 3}), 3.0, 1e-12);
}

}  // namespace
}  // namespace plslam::vo
