// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/points/fast_score.h"

#include <algorithm>
#include <cstddef>

#include "core/features/image/vector_kernels.h"

namespace plslam {
namespace {

/// Pixels that fill a vector register.
constexpr int kScoreBlock = 32;

uint8_t Min(uint8_t a, uint8_t b) { return a < b ? a : b; }
uint8_t Max(uint8_t a, uint8_t b) { return a < b ? b : a; }

/// Rows of the neighbourhood, shifted so that index x is the neighbour of pixel x.
struct Circle {
  const uint8_t *p0, *p1, *p2, *p3, *p4, *p5, *p6, *p7, *p8, *p9, *p10, *p11, *p12, *p13, *p14, *p15;
};

/// The circle of radius 3, clockwise from the top.
Circle CircleAround(const uint8_t* row, size_t step) {
  const auto at = [row, step = static_cast<ptrdiff_t>(step)](int x, int y) { return row + y * step + x; };
  return {at(0, -3), at(1, -3), at(2, -2), at(3, -1), at(3, 0),  at(3, 1),   at(2, 2),   at(1, 3),
          at(0, 3),  at(-1, 3), at(-2, 2), at(-3, 1), at(-3, 0), at(-3, -1), at(-2, -2), at(-1, -3)};
}

/// Computes scores of `count` pixels, starting at `row`.
///
/// The best arc's darkest pixel is the maximum over the 16 arcs of 9 of their minima. Arcs k and k+1 share 8 pixels,
/// so they are processed in pairs: min(the 8, max(the first, the last)). Minima of 8 come from those of 4 and 2.
/// Written out, without arrays, in the form that the compiler vectorises.
PLSLAM_AVX2_CLONES
void ScoreRow(const uint8_t* __restrict row, const Circle& c, int count, uint8_t* __restrict scores) {
  const uint8_t* __restrict r0 = c.p0;
  const uint8_t* __restrict r1 = c.p1;
  const uint8_t* __restrict r2 = c.p2;
  const uint8_t* __restrict r3 = c.p3;
  const uint8_t* __restrict r4 = c.p4;
  const uint8_t* __restrict r5 = c.p5;
  const uint8_t* __restrict r6 = c.p6;
  const uint8_t* __restrict r7 = c.p7;
  const uint8_t* __restrict r8 = c.p8;
  const uint8_t* __restrict r9 = c.p9;
  const uint8_t* __restrict r10 = c.p10;
  const uint8_t* __restrict r11 = c.p11;
  const uint8_t* __restrict r12 = c.p12;
  const uint8_t* __restrict r13 = c.p13;
  const uint8_t* __restrict r14 = c.p14;
  const uint8_t* __restrict r15 = c.p15;
  for (int x = 0; x < count; ++x) {
    const uint8_t p0 = r0[x];
    const uint8_t p1 = r1[x];
    const uint8_t p2 = r2[x];
    const uint8_t p3 = r3[x];
    const uint8_t p4 = r4[x];
    const uint8_t p5 = r5[x];
    const uint8_t p6 = r6[x];
    const uint8_t p7 = r7[x];
    const uint8_t p8 = r8[x];
    const uint8_t p9 = r9[x];
    const uint8_t p10 = r10[x];
    const uint8_t p11 = r11[x];
    const uint8_t p12 = r12[x];
    const uint8_t p13 = r13[x];
    const uint8_t p14 = r14[x];
    const uint8_t p15 = r15[x];
    // Two pixels, starting at k.
    const uint8_t low2_1 = Min(p1, p2);
    const uint8_t high2_1 = Max(p1, p2);
    const uint8_t low2_3 = Min(p3, p4);
    const uint8_t high2_3 = Max(p3, p4);
    const uint8_t low2_5 = Min(p5, p6);
    const uint8_t high2_5 = Max(p5, p6);
    const uint8_t low2_7 = Min(p7, p8);
    const uint8_t high2_7 = Max(p7, p8);
    const uint8_t low2_9 = Min(p9, p10);
    const uint8_t high2_9 = Max(p9, p10);
    const uint8_t low2_11 = Min(p11, p12);
    const uint8_t high2_11 = Max(p11, p12);
    const uint8_t low2_13 = Min(p13, p14);
    const uint8_t high2_13 = Max(p13, p14);
    const uint8_t low2_15 = Min(p15, p0);
    const uint8_t high2_15 = Max(p15, p0);
    // Four.
    const uint8_t low4_1 = Min(low2_1, low2_3);
    const uint8_t high4_1 = Max(high2_1, high2_3);
    const uint8_t low4_3 = Min(low2_3, low2_5);
    const uint8_t high4_3 = Max(high2_3, high2_5);
    const uint8_t low4_5 = Min(low2_5, low2_7);
    const uint8_t high4_5 = Max(high2_5, high2_7);
    const uint8_t low4_7 = Min(low2_7, low2_9);
    const uint8_t high4_7 = Max(high2_7, high2_9);
    const uint8_t low4_9 = Min(low2_9, low2_11);
    const uint8_t high4_9 = Max(high2_9, high2_11);
    const uint8_t low4_11 = Min(low2_11, low2_13);
    const uint8_t high4_11 = Max(high2_11, high2_13);
    const uint8_t low4_13 = Min(low2_13, low2_15);
    const uint8_t high4_13 = Max(high2_13, high2_15);
    const uint8_t low4_15 = Min(low2_15, low2_1);
    const uint8_t high4_15 = Max(high2_15, high2_1);
    // The arcs that share the eight pixels starting at k.
    uint8_t brightest = 0;
    uint8_t darkest = 255;
    brightest = Max(brightest, Min(Min(low4_1, low4_5), Max(p0, p9)));
    darkest = Min(darkest, Max(Max(high4_1, high4_5), Min(p0, p9)));
    brightest = Max(brightest, Min(Min(low4_3, low4_7), Max(p2, p11)));
    darkest = Min(darkest, Max(Max(high4_3, high4_7), Min(p2, p11)));
    brightest = Max(brightest, Min(Min(low4_5, low4_9), Max(p4, p13)));
    darkest = Min(darkest, Max(Max(high4_5, high4_9), Min(p4, p13)));
    brightest = Max(brightest, Min(Min(low4_7, low4_11), Max(p6, p15)));
    darkest = Min(darkest, Max(Max(high4_7, high4_11), Min(p6, p15)));
    brightest = Max(brightest, Min(Min(low4_9, low4_13), Max(p8, p1)));
    darkest = Min(darkest, Max(Max(high4_9, high4_13), Min(p8, p1)));
    brightest = Max(brightest, Min(Min(low4_11, low4_15), Max(p10, p3)));
    darkest = Min(darkest, Max(Max(high4_11, high4_15), Min(p10, p3)));
    brightest = Max(brightest, Min(Min(low4_13, low4_1), Max(p12, p5)));
    darkest = Min(darkest, Max(Max(high4_13, high4_1), Min(p12, p5)));
    brightest = Max(brightest, Min(Min(low4_15, low4_3), Max(p14, p7)));
    darkest = Min(darkest, Max(Max(high4_15, high4_3), Min(p14, p7)));
    const uint8_t center = row[x];
    const auto above = static_cast<uint8_t>(Max(brightest, center) - center);
    const auto below = static_cast<uint8_t>(center - Min(darkest, center));
    scores[x] = Max(above, below);
  }
}

/// Rows of scores above, at, and below; each has a readable pixel before and after.
PLSLAM_AVX2_CLONES
void SuppressRow(const uint8_t* above, const uint8_t* row, const uint8_t* below, int count, uint8_t min_score,
                 uint8_t* maxima) {
  for (int x = 0; x < count; ++x) {
    const uint8_t before = std::max(std::max(above[x - 1], above[x]), std::max(above[x + 1], row[x - 1]));
    const uint8_t after = std::max(std::max(below[x - 1], below[x]), std::max(below[x + 1], row[x + 1]));
    const uint8_t score = row[x];
    const bool keep = (score >= before) & (score > after) & (score >= min_score);
    maxima[x] = keep ? score : static_cast<uint8_t>(0);
  }
}

}  // namespace

void FastScores(const cv::Mat& image, cv::Mat& scores) {
  scores.create(image.size(), CV_8UC1);
  const int count = image.cols - 2 * kFastRadius_px;
  for (int y = 0; y < image.rows; ++y) {
    auto* out = scores.ptr<uint8_t>(y);
    if (count <= 0 || y < kFastRadius_px || y >= image.rows - kFastRadius_px) {
      std::fill_n(out, image.cols, static_cast<uint8_t>(0));
      continue;
    }
    std::fill_n(out, kFastRadius_px, static_cast<uint8_t>(0));
    InWholeBlocks<kScoreBlock>(count, [&](int begin, int n) {
      const uint8_t* row = image.ptr<uint8_t>(y) + kFastRadius_px + begin;
      ScoreRow(row, CircleAround(row, image.step), n, out + kFastRadius_px + begin);
    });
    std::fill_n(out + kFastRadius_px + count, kFastRadius_px, static_cast<uint8_t>(0));
  }
}

void SuppressNonMaxima(const cv::Mat& scores, int min_score, cv::Mat& maxima) {
  maxima.create(scores.size(), CV_8UC1);
  for (int y = 0; y < scores.rows; ++y) {
    auto* out = maxima.ptr<uint8_t>(y);
    std::fill_n(out, scores.cols, static_cast<uint8_t>(0));
    if (y == 0 || y == scores.rows - 1 || scores.cols < 3) continue;
    InWholeBlocks<kScoreBlock>(scores.cols - 2, [&](int begin, int n) {
      const uint8_t* row = scores.ptr<uint8_t>(y) + 1 + begin;
      SuppressRow(row - scores.step, row, row + scores.step, n, static_cast<uint8_t>(std::clamp(min_score, 1, 255)),
                  out + 1 + begin);
    });
  }
}

}  // namespace plslam
