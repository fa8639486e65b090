// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/line_edge_map.h"

#include <cstdlib>

#include "core/features/image/cpu_clones.h"

namespace plslam {
namespace {

constexpr int kMargin = 2;

int16_t Magnitude(int16_t v) { return static_cast<int16_t>(v < 0 ? -v : v); }

int16_t Mask(bool v) { return static_cast<int16_t>(-static_cast<int16_t>(v)); }

/// Pointers stand at the first pixel to mark; `up` and `down` are the dy rows above and below.
PLSLAM_AVX2_CLONES void MarkRow(const int16_t* dx, const int16_t* dy, const int16_t* up, const int16_t* down,
                                int count, int16_t threshold, uint8_t* __restrict out) {
  // Everything is loaded and computed, then chosen by masks: no branch is in the way of vector code.
  for (int x = 0; x < count; ++x) {
    const int16_t ax = Magnitude(dx[x]);
    const int16_t ay = Magnitude(dy[x]);
    const int16_t left = Magnitude(dx[x - 1]);
    const int16_t right = Magnitude(dx[x + 1]);
    const int16_t above = Magnitude(up[x]);
    const int16_t below = Magnitude(down[x]);
    const int16_t steep = Mask((ax >= ay) & (ax >= threshold) & (ax > left) & (ax >= right));
    const int16_t flat = Mask((ay > ax) & (ay >= threshold) & (ay > above) & (ay >= below));
    out[x] = static_cast<uint8_t>((steep & kSteepEdge) | (flat & kFlatEdge));
  }
}

}  // namespace

void ComputeEdgeMap(const Gradients& gradients, int threshold, cv::Mat& out) {
  const int width = gradients.dx.cols;
  const int height = gradients.dx.rows;
  out.create(height, width, CV_8UC1);
  out.setTo(kNoEdge);
  if (width <= 2 * kMargin || height <= 2 * kMargin) return;
  for (int y = kMargin; y < height - kMargin; ++y) {
    MarkRow(gradients.dx.ptr<int16_t>(y) + kMargin, gradients.dy.ptr<int16_t>(y) + kMargin,
            gradients.dy.ptr<int16_t>(y - 1) + kMargin, gradients.dy.ptr<int16_t>(y + 1) + kMargin,
            width - 2 * kMargin, static_cast<int16_t>(threshold), out.ptr<uint8_t>(y) + kMargin);
  }
}

}  // namespace plslam
