// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/image/gradients.h"

#include <algorithm>

#include "core/features/image/vector_kernels.h"

namespace plslam {
namespace {

constexpr int kPad = 2;
/// Pixels of a row that vector code processes at once.
constexpr int kGradientBlock = 32;

/// Column sums of five rows: `smooth` [1 4 6 4 1] and `slope` [-1 -2 0 2 1].
PLSLAM_AVX2_CLONES void CombineRows(const uint8_t* const rows[5], int width, int16_t* __restrict smooth,
                                    int16_t* __restrict slope) {
  const uint8_t* a = rows[0];
  const uint8_t* b = rows[1];
  const uint8_t* c = rows[2];
  const uint8_t* d = rows[3];
  const uint8_t* e = rows[4];
  for (int x = 0; x < width; ++x) {
    smooth[x] = static_cast<int16_t>(a[x] + e[x] + 4 * (b[x] + d[x]) + 6 * c[x]);
    slope[x] = static_cast<int16_t>(e[x] - a[x] + 2 * (d[x] - b[x]));
  }
}

PLSLAM_AVX2_CLONES void CombineColumns(const int16_t* smooth, const int16_t* slope, int width, int16_t* __restrict dx,
                                       int16_t* __restrict dy) {
  for (int x = 0; x < width; ++x) {
    dx[x] = static_cast<int16_t>(smooth[x + 2] - smooth[x - 2] + 2 * (smooth[x + 1] - smooth[x - 1]));
    dy[x] = static_cast<int16_t>(slope[x - 2] + slope[x + 2] + 4 * (slope[x - 1] + slope[x + 1]) + 6 * slope[x]);
  }
}

void RepeatEnds(int16_t* row, int width) {
  for (int i = 1; i <= kPad; ++i) {
    row[-i] = row[0];
    row[width - 1 + i] = row[width - 1];
  }
}

}  // namespace

void ComputeGradients(const cv::Mat& image, Gradients& out) {
  CV_Assert(image.type() == CV_8UC1 || image.empty());
  const int width = image.cols;
  const int height = image.rows;
  out.dx.create(height, width, CV_16SC1);
  out.dy.create(height, width, CV_16SC1);
  if (width == 0 || height == 0) return;
  std::vector<int16_t> buffer(static_cast<size_t>(2 * (width + 2 * kPad)));
  int16_t* smooth = buffer.data() + kPad;
  int16_t* slope = smooth + buffer.size() / 2;
  for (int y = 0; y < height; ++y) {
    InWholeBlocks<kGradientBlock>(width, [&](int begin, int n) {
      const uint8_t* rows[5];
      for (int i = 0; i < 5; ++i) rows[i] = image.ptr<uint8_t>(std::clamp(y + i - 2, 0, height - 1)) + begin;
      CombineRows(rows, n, smooth + begin, slope + begin);
    });
    RepeatEnds(smooth, width);
    RepeatEnds(slope, width);
    auto* dx = out.dx.ptr<int16_t>(y);
    auto* dy = out.dy.ptr<int16_t>(y);
    InWholeBlocks<kGradientBlock>(
        width, [&](int begin, int n) { CombineColumns(smooth + begin, slope + begin, n, dx + begin, dy + begin); });
  }
}

}  // namespace plslam
