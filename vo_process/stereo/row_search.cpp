// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/row_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/features/image/vector_kernels.h"

namespace plslam::vo {
namespace {

constexpr int kWindowHalf = 5;
constexpr int kWindowSide = 2 * kWindowHalf + 1;
constexpr int kWindowRow =
    16;  // pixels of a patch row in memory, the last five with weight 0: whole vector registers
constexpr int kWindowPixels = kWindowSide * kWindowSide;
/// Positions nearer to the best than this belong to the same peak.
constexpr int kPeakHalfWidth = 3;
/// Grey levels^2: least variance of a patch with contrast.
constexpr double kMinVariance = 4.0;

using WindowPixels = std::array<int16_t, static_cast<size_t>(kWindowSide) * kWindowRow>;

/// Converts a row under the patches to 16 bits.
PLSLAM_AVX2_CLONES
void Widen(const uint8_t* row, int count, int16_t* out) {
  for (int i = 0; i < count; ++i) out[i] = row[i];
}

/// Products of the patch with `places` windows of the strip, one pixel apart.
PLSLAM_AVX2_CLONES
void Correlate(const int16_t* patch, const int16_t* strip, int stride, int places, int* cross) {
  for (int p = 0; p < places; ++p) {
    int sum = 0;
    for (int y = 0; y < kWindowSide; ++y) {
      const int16_t* a = patch + y * kWindowRow;
      const int16_t* b = strip + y * stride + p;
      for (int x = 0; x < kWindowRow; ++x) sum += a[x] * b[x];
    }
    cross[p] = sum;
  }
}

/// Sums and sums of squares of the columns of the strip.
PLSLAM_AVX2_CLONES
void ColumnSums(const int16_t* strip, int stride, int columns, int* sum, int* square) {
  for (int x = 0; x < columns; ++x) sum[x] = square[x] = 0;
  for (int y = 0; y < kWindowSide; ++y) {
    const int16_t* row = strip + y * stride;
    for (int x = 0; x < columns; ++x) {
      sum[x] += row[x];
      square[x] += row[x] * row[x];
    }
  }
}

/// Converts column sums to window sums, in place.
void WindowSums(std::vector<int>& columns, int places) {
  int window = 0;
  for (int x = 0; x < kWindowSide; ++x) window += columns[x];
  for (int p = 0; p < places; ++p) {
    const int first = columns[p];
    columns[p] = window;
    window += columns[p + kWindowSide] - first;
  }
}

/// Left patch minus its rounded mean; its energy is exact for the stored values.
struct LeftPatch {
  WindowPixels pixels;
  int sum = 0;
  double energy = 0.0;
};

LeftPatch ReadPatch(const cv::Mat& image, int u, int v) {
  std::array<uint8_t, static_cast<size_t>(kWindowSide) * kWindowRow> bytes{};
  for (int y = 0; y < kWindowSide; ++y) {
    const uint8_t* row = image.ptr<uint8_t>(v + y - kWindowHalf) + u - kWindowHalf;
    std::copy_n(row, kWindowSide, bytes.data() + y * kWindowRow);
  }
  const int total = std::accumulate(bytes.begin(), bytes.end(), 0);
  const int mean = (total + kWindowPixels / 2) / kWindowPixels;
  LeftPatch patch;
  patch.sum = total - mean * kWindowPixels;
  for (size_t i = 0; i < bytes.size(); ++i) patch.pixels[i] = static_cast<int16_t>(bytes[i] - mean);
  for (int y = 0; y < kWindowSide; ++y) {
    std::fill_n(patch.pixels.data() + y * kWindowRow + kWindowSide, kWindowRow - kWindowSide, int16_t{0});
  }
  const int square = std::inner_product(patch.pixels.begin(), patch.pixels.end(), patch.pixels.begin(), 0);
  patch.energy = square - static_cast<double>(patch.sum) * patch.sum / kWindowPixels;
  return patch;
}

/// Returns the highest of the scores [first, last); 0 if there are none.
float Highest(const std::vector<float>& scores, int first, int last) {
  return last > first ? Eigen::Map<const Eigen::ArrayXf>(scores.data() + first, last - first).maxCoeff() : 0.0F;
}

/// Returns the index of the first score in [first, last) that equals `score`, which must be one of them.
int IndexOf(float score, const std::vector<float>& scores, int first, int last) {
  return static_cast<int>(std::find(scores.begin() + first, scores.begin() + last, score) - scores.begin());
}

}  // namespace

std::optional<RowMatch> RowSearch::Find(const Eigen::Vector2d& left_px, double scale, double min_disparity_px,
                                        double max_disparity_px) {
  const HalvedPair::Level& level = pair_->LevelFor(scale);
  const Eigen::Vector2d left = level.FromImage(left_px);
  const int u = static_cast<int>(std::lround(left.x()));
  const int v = static_cast<int>(std::lround(left.y()));
  const int columns = level.left.cols;
  const int right_v = v + static_cast<int>(std::lround(rows_.MatchOffset_px(left_px, 0.0) / level.size_px));
  const auto is_inside = [&level](int row) { return row >= kWindowHalf && row < level.left.rows - kWindowHalf; };
  if (u < kWindowHalf || u >= columns - kWindowHalf || !is_inside(v) || !is_inside(right_v)) return std::nullopt;
  const LeftPatch patch = ReadPatch(level.left, u, v);
  if (!(patch.energy > kMinVariance * kWindowPixels)) return std::nullopt;

  // Centres in the right image, left to right.
  const int first = std::max(u - static_cast<int>(std::ceil(max_disparity_px / level.size_px)), kWindowHalf);
  const int last =
      std::min(u - static_cast<int>(std::floor(min_disparity_px / level.size_px)), columns - 1 - kWindowHalf);
  const int places = last - first + 1;
  if (places <= 0) return std::nullopt;
  const int stride = places + kWindowRow;
  strip_.assign(static_cast<size_t>(kWindowSide) * stride, 0);
  for (int y = 0; y < kWindowSide; ++y) {
    const int start = first - kWindowHalf;
    Widen(level.right.ptr<uint8_t>(right_v + y - kWindowHalf) + start, std::min(stride, columns - start),
          strip_.data() + static_cast<size_t>(y) * stride);
  }
  cross_.resize(places);
  sum_.resize(stride);
  square_.resize(stride);
  score_.resize(places);
  Correlate(patch.pixels.data(), strip_.data(), stride, places, cross_.data());
  ColumnSums(strip_.data(), stride, stride, sum_.data(), square_.data());
  WindowSums(sum_, places);
  WindowSums(square_, places);

  for (int p = 0; p < places; ++p) {
    const double mean = static_cast<double>(sum_[p]) / kWindowPixels;
    const double energy = square_[p] - mean * sum_[p];
    const double cross = cross_[p] - mean * patch.sum;
    // Squared, which keeps the order; negative correlations count as 0. Computed for all, without branches.
    const double squared = cross * cross / (energy * patch.energy);
    score_[p] = static_cast<float>(cross > 0.0 && energy > 0.0 ? squared : 0.0);
  }
  const float highest = Highest(score_, 0, places);
  if (!(highest > 0.0F)) return std::nullopt;
  const int best = IndexOf(highest, score_, 0, places);
  RowMatch match{(u - first - best) * level.size_px, std::sqrt(static_cast<double>(highest))};
  const int left_end = std::max(best - kPeakHalfWidth + 1, 0);
  const int right_begin = std::min(best + kPeakHalfWidth, places);
  const float left_of = Highest(score_, 0, left_end);
  const float right_of = Highest(score_, right_begin, places);
  if (!(std::max(left_of, right_of) > 0.0F)) return match;
  const int second =
      left_of >= right_of ? IndexOf(left_of, score_, 0, left_end) : IndexOf(right_of, score_, right_begin, places);
  match.second_disparity_px = (u - first - second) * level.size_px;
  match.second_correlation = std::sqrt(static_cast<double>(score_[second]));
  return match;
}

}  // namespace plslam::vo
