// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/coarse_lines.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/features/lines/line_extractor.h"
#include "core/features/lines/line_sigma.h"
#include "tests/unit/lines/rendered_edges.h"

namespace plslam {
namespace {

const cv::Size kSize(400, 300);

/// A slanted bar that moved by `moved_px` along the rows while the shutter was open; its long sides without that,
/// directed as segments are.
struct MovedBar {
  explicit MovedBar(int moved_px) {
    const Segment2 axis{{170.0, 40.0}, {230.0, 260.0}};
    cv::Mat sum(kSize, CV_32F, cv::Scalar(0));
    for (int i = 0; i < moved_px; ++i) {
      const Eigen::Vector2d shift(i - 0.5 * (moved_px - 1), 0.0);
      const cv::Mat part = test::RenderBars(kSize, 90, {{{axis.p + shift, axis.q + shift}, 60.0, 150.0}});
      cv::accumulate(part, sum);
    }
    sum.convertTo(image, CV_8U, 1.0 / moved_px);
    test::AddNoise(image, 2.0, 1);
    const Eigen::Vector2d along = (axis.q - axis.p).normalized();
    const Eigen::Vector2d to_side = 30.0 * Eigen::Vector2d(-along.y(), along.x());
    sides = {Segment2{axis.q + to_side, axis.p + to_side}, Segment2{axis.p - to_side, axis.q - to_side}};
  }

  cv::Mat image;
  std::vector<Segment2> sides;
};

/// Distance of the farther end of a line from the infinite one through `truth`.
double FartherEnd(const Segment2& line, const Segment2& truth) {
  const Eigen::Vector2d along = (truth.q - truth.p).normalized();
  const Eigen::Vector2d normal(-along.y(), along.x());
  return std::max(std::abs(normal.dot(line.p - truth.p)), std::abs(normal.dot(line.q - truth.p)));
}

std::vector<LineFeature> Extract(const cv::Mat& image, int levels, int max_lines = 200) {
  LineOptions options;
  options.levels = levels;
  options.max_lines = max_lines;
  return LineExtractor(options).Extract(image);
}

/// Returns the lines longer than 60 px: those of the bar's long sides.
std::vector<LineFeature> Long(const std::vector<LineFeature>& lines) {
  std::vector<LineFeature> kept;
  for (const LineFeature& line : lines) {
    if (line.segment.Length() > 60.0) kept.push_back(line);
  }
  return kept;
}

TEST(CoarseLines, BlurredEdgeIsOneLineInItsMiddle) {
  for (const int moved_px : {9, 15, 21, 27}) {
    const MovedBar bar(moved_px);
    const std::vector<LineFeature> lines = Long(Extract(bar.image, 3));
    for (const Segment2& side : bar.sides) {
      double length = 0.0;
      for (const LineFeature& line : lines) {
        const double off_px = FartherEnd(line.segment, side);
        if (off_px > 0.5 * moved_px) continue;
        length += line.segment.Length();
        EXPECT_GT(line.octave, 0) << moved_px;
        EXPECT_LT(off_px, 4.0 * EndSigma_px(line)) << moved_px << " px of blur, sigma " << EndSigma_px(line);
      }
      // Once along the side, and not several times side by side.
      EXPECT_GT(length, 0.6 * side.Length()) << moved_px;
      EXPECT_LT(length, 1.05 * side.Length()) << moved_px;
    }
  }
}

TEST(CoarseLines, BlurredEdgeIsOffCentreWithoutThem) {
  const MovedBar bar(21);
  for (const LineFeature& line : Long(Extract(bar.image, 1))) {
    const double off_px = std::min(FartherEnd(line.segment, bar.sides[0]), FartherEnd(line.segment, bar.sides[1]));
    EXPECT_GT(off_px, 4.0 * EndSigma_px(line));
  }
}

TEST(CoarseLines, SharpLinesAreUnchanged) {
  const MovedBar bar(1);
  const std::vector<LineFeature> whole = Extract(bar.image, 1);
  const std::vector<LineFeature> all = Extract(bar.image, 3);
  ASSERT_EQ(whole.size(), 4U);
  ASSERT_EQ(all.size(), 4U);
  for (size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(all[i].segment.p, whole[i].segment.p);
    EXPECT_EQ(all[i].segment.q, whole[i].segment.q);
    EXPECT_EQ(all[i].octave, 0);
  }
}

TEST(CoarseLines, EnoughSharpLinesNeedNoCoarseLines) {
  // The image of a blurred bar beside four sharp edges: 16 lines are requested, so four are enough.
  cv::Mat both;
  cv::hconcat(MovedBar(21).image, MovedBar(1).image, both);
  for (const LineFeature& line : Extract(both, 3, 16)) EXPECT_EQ(line.octave, 0);
  int coarse = 0;
  for (const LineFeature& line : Extract(both, 3, 200)) coarse += line.octave > 0 ? 1 : 0;
  EXPECT_GE(coarse, 2);
}

TEST(CoarseLines, ImagesTooSmallToBeHalvedHaveNone) {
  for (const int size : {1, 2, 15, 31}) {
    EXPECT_NO_THROW(Extract(test::NoiseImage({size, size}, 100, 20, 1), 5)) << size;
  }
}

TEST(EdgeWidth, EqualsTheWidthOfTheSlope) {
  for (const int moved_px : {1, 5, 9, 11}) {
    const MovedBar bar(moved_px);
    Gradients gradients;
    ComputeGradients(bar.image, gradients);
    for (const Segment2& side : bar.sides) {
      const Eigen::Vector2d along = (side.q - side.p).normalized();
      // Blur is along the rows, the width across the edge.
      const double across_px = moved_px * std::abs(along.y());
      EXPECT_NEAR(EdgeWidth_px(gradients, side), std::max(4.0, across_px), 2.0) << moved_px;
    }
  }
}

TEST(EdgeWidth, NoLengthOrOutsideOfTheImage) {
  Gradients gradients;
  ComputeGradients(MovedBar(1).image, gradients);
  EXPECT_EQ(EdgeWidth_px(gradients, {{5.0, 5.0}, {5.0, 5.0}}), 0);
  EXPECT_LE(EdgeWidth_px(gradients, {{-50.0, -3.0}, {900.0, -3.0}}), kMaxEdgeWidth_px);
}

}  // namespace
}  // namespace plslam
