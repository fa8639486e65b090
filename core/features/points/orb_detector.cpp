// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/points/orb_detector.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

#include "core/features/image/vector_kernels.h"
#include "core/features/matching/buckets.h"
#include "core/features/points/fast_score.h"

namespace plslam {
namespace {

constexpr int kRadius_px = 3;

}  // namespace

double CornerRatio(const cv::Mat& image, int x, int y) {
  const auto step = static_cast<std::ptrdiff_t>(image.step);
  int64_t xx = 0;
  int64_t xy = 0;
  int64_t yy = 0;
  for (int row = y - kRadius_px; row <= y + kRadius_px; ++row) {
    const uint8_t* p = image.ptr<uint8_t>(row) + x - kRadius_px;
    for (int i = 0; i <= 2 * kRadius_px; ++i, ++p) {
      const int gx = p[1] - p[-1];
      const int gy = p[step] - p[-step];
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  }
  const auto trace = static_cast<double>(xx + yy);
  const auto difference = static_cast<double>(xx - yy);
  const double spread = std::sqrt(difference * difference + 4.0 * static_cast<double>(xy) * static_cast<double>(xy));
  return trace > 0.0 ? (trace - spread) / (trace + spread) : 0.0;
}

namespace {

constexpr int kCell_px = 32;
/// Expected number of corners in a cell of `SpreadCorners`.
constexpr double kCornersPerCell = 2.0;
/// Capacity reserved for the corners of an image before they are spread.
constexpr size_t kCornersExpected = 4096;

/// Visits the indices of the non-zero bytes among `count`, eight at a time, because most are zero.
template <class Visit>
void ForEachNonZero(const uint8_t* row, int count, const Visit& visit) {
  int x = 0;
  for (; x + 8 <= count; x += 8) {
    uint64_t eight = 0;
    std::memcpy(&eight, row + x, 8);
    if (eight == 0) continue;
    while (eight != 0) {
      const int k = std::countr_zero(eight) / 8;  // the first in memory: little-endian
      visit(x + k);
      eight &= ~(uint64_t{0xff} << (8 * k));
    }
  }
  for (; x < count; ++x) {
    if (row[x] != 0) visit(x);
  }
}

PLSLAM_AVX2_CLONES
void TakeLargest(const uint8_t* row, int count, uint8_t* __restrict largest) {
  for (int x = 0; x < count; ++x) largest[x] = std::max(largest[x], row[x]);
}

PLSLAM_AVX2_CLONES
void DropBelow(const uint8_t* least, int count, uint8_t* __restrict row) {
  for (int x = 0; x < count; ++x) row[x] = row[x] < least[x] ? static_cast<uint8_t>(0) : row[x];
}

/// Processes a row of cells of the score map, `band`: in cells with a score above `threshold`, other scores become 0.
/// Works on whole rows of pixels, because there are far more weak corners than needed.
void DropWeakBesideStrong(int threshold, const cv::Rect& band, cv::Mat& scores) {
  std::vector<uint8_t> least(static_cast<size_t>(band.width), 0);
  for (int y = band.y; y < band.br().y; ++y) {
    TakeLargest(scores.ptr<uint8_t>(y) + band.x, band.width, least.data());
  }
  for (int x = 0; x < band.width; x += kCell_px) {
    const auto first = least.begin() + x;
    const auto last = least.begin() + std::min(x + kCell_px, band.width);
    const bool has_strong = *std::max_element(first, last) > threshold;
    std::fill(first, last, static_cast<uint8_t>(has_strong ? threshold + 1 : 0));
  }
  for (int y = band.y; y < band.br().y; ++y) {
    DropBelow(least.data(), band.width, scores.ptr<uint8_t>(y) + band.x);
  }
}

/// Vertex of the parabola through three equidistant values, the middle one being the largest: in [-1/2, 1/2].
double VertexOffset(int before, int middle, int after) {
  const int curvature = 2 * middle - before - after;
  return curvature > 0 ? 0.5 * (after - before) / curvature : 0.0;
}

/// Orders by descending response; equal ones by position.
bool Better(const Corner& a, const Corner& b) {
  if (a.response != b.response) return a.response > b.response;
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

}  // namespace

std::vector<Corner> CornerDetector::Detect(const cv::Mat& image, int threshold, int low_threshold, int margin_px) {
  const int margin = std::max(margin_px, kFastRadius_px);
  const int width = image.cols - 2 * margin;
  const int height = image.rows - 2 * margin;
  if (width <= 0 || height <= 0) return {};
  FastScores(image, scores_);
  SuppressNonMaxima(scores_, std::min(threshold, low_threshold) + 1, maxima_);

  std::vector<Corner> corners;
  corners.reserve(kCornersExpected);
  for (int y = margin; y < margin + height; y += kCell_px) {
    const int rows = std::min(kCell_px, margin + height - y);
    DropWeakBesideStrong(threshold, cv::Rect(margin, y, width, rows), maxima_);
    for (int v = y; v < y + rows; ++v) {
      const uint8_t* row = maxima_.ptr<uint8_t>(v);
      ForEachNonZero(row + margin, width, [&](int x) { corners.push_back({margin + x, v, row[margin + x]}); });
    }
  }
  return corners;
}

Eigen::Vector2d CornerDetector::SubPixel(const Corner& corner) const {
  const uint8_t* score = scores_.ptr<uint8_t>(corner.y) + corner.x;
  const auto step = static_cast<ptrdiff_t>(scores_.step);
  return {corner.x + VertexOffset(score[-1], score[0], score[1]),
          corner.y + VertexOffset(score[-step], score[0], score[step])};
}

std::vector<Corner> SpreadCorners(const std::vector<Corner>& corners, int quota, int width_px, int height_px) {
  if (quota <= 0) return {};
  if (static_cast<int>(corners.size()) <= quota) return corners;
  const double cell_px = std::max(4.0, std::sqrt(kCornersPerCell * width_px * height_px / quota));
  const int columns = static_cast<int>(width_px / cell_px) + 1;
  const int rows = static_cast<int>(height_px / cell_px) + 1;
  Buckets<Corner> cells(corners, static_cast<size_t>(columns) * rows, [&](const Corner& c) {
    return static_cast<int>(c.y / cell_px) * columns + static_cast<int>(c.x / cell_px);
  });

  std::vector<Corner> kept;
  std::vector<Corner> offered;
  kept.reserve(quota);
  offered.reserve(cells.size());
  for (size_t turn = 0; kept.size() < static_cast<size_t>(quota); ++turn) {
    offered.clear();
    for (size_t c = 0; c < cells.size(); ++c) {
      const std::span<Corner> cell = cells[c];
      if (turn >= cell.size()) continue;
      const auto first = cell.begin() + static_cast<ptrdiff_t>(turn);
      const auto last = cell.end();
      // Selects the best on demand instead of sorting: few turns are needed, and cells may contain hundreds.
      std::iter_swap(first, std::min_element(first, last, Better));
      offered.push_back(*first);
    }
    const size_t room = static_cast<size_t>(quota) - kept.size();
    if (offered.size() > room) {
      std::sort(offered.begin(), offered.end(), Better);
      offered.resize(room);
    }
    kept.insert(kept.end(), offered.begin(), offered.end());
  }
  return kept;
}

}  // namespace plslam
