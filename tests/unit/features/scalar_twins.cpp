// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/features/scalar_twins.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "core/features/lines/line_grower.h"
#include "core/features/points/fast_score.h"
#include "core/features/points/orb_descriptor.h"

namespace plslam::test {

void ScalarHammingDistances(const Descriptor& query, const std::vector<Descriptor>& descriptors,
                            uint16_t* distances) {
  for (size_t i = 0; i < descriptors.size(); ++i) {
    int distance = 0;
    for (size_t k = 0; k < query.size(); ++k) distance += std::popcount(query[k] ^ descriptors[i][k]);
    distances[i] = static_cast<uint16_t>(distance);
  }
}

void ScalarFastScores(const cv::Mat& image, cv::Mat& scores) {
  constexpr int kX[16] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
  constexpr int kY[16] = {-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
  std::array<std::ptrdiff_t, 16> circle{};
  for (size_t k = 0; k < 16; ++k) circle[k] = kY[k] * static_cast<std::ptrdiff_t>(image.step) + kX[k];
  scores = cv::Mat::zeros(image.size(), CV_8UC1);
  for (int y = kFastRadius_px; y < image.rows - kFastRadius_px; ++y) {
    for (int x = kFastRadius_px; x < image.cols - kFastRadius_px; ++x) {
      const uint8_t* centre = image.ptr<uint8_t>(y) + x;
      std::array<uint8_t, 16> p{};
      for (size_t k = 0; k < 16; ++k) p[k] = centre[circle[k]];
      std::array<uint8_t, 8> low{}, high{}, low4{}, high4{};
      for (size_t k = 0; k < 8; ++k) {
        low[k] = std::min(p[2 * k + 1], p[(2 * k + 2) % 16]);
        high[k] = std::max(p[2 * k + 1], p[(2 * k + 2) % 16]);
      }
      for (size_t k = 0; k < 8; ++k) {
        low4[k] = std::min(low[k], low[(k + 1) % 8]);
        high4[k] = std::max(high[k], high[(k + 1) % 8]);
      }
      uint8_t brightest = 0, darkest = 255;
      for (size_t k = 0; k < 8; ++k) {
        const uint8_t first = p[2 * k], last = p[(2 * k + 9) % 16];
        brightest = std::max(brightest, std::min(std::min(low4[k], low4[(k + 2) % 8]), std::max(first, last)));
        darkest = std::min(darkest, std::max(std::max(high4[k], high4[(k + 2) % 8]), std::min(first, last)));
      }
      scores.at<uint8_t>(y, x) = static_cast<uint8_t>(std::max({brightest - *centre, *centre - darkest, 0}));
    }
  }
}

void ScalarSuppressNonMaxima(const cv::Mat& scores, int min_score, cv::Mat& maxima) {
  maxima = cv::Mat::zeros(scores.size(), CV_8UC1);
  for (int y = 1; y < scores.rows - 1; ++y) {
    const uint8_t* row = scores.ptr<uint8_t>(y);
    const uint8_t* above = row - scores.step;
    const uint8_t* below = row + scores.step;
    for (int x = 1; x < scores.cols - 1; ++x) {
      const uint8_t before = std::max(std::max(above[x - 1], above[x]), std::max(above[x + 1], row[x - 1]));
      const uint8_t after = std::max(std::max(below[x - 1], below[x]), std::max(below[x + 1], row[x + 1]));
      const bool keep = (row[x] >= before) & (row[x] > after) & (row[x] >= min_score);
      maxima.at<uint8_t>(y, x) = keep ? row[x] : uint8_t{0};
    }
  }
}

std::array<int, 2> ScalarDiscMoments(const cv::Mat& image, int x, int y) {
  std::array<int, 2> moments{};
  for (int v = -kOrbPatchRadius_px; v <= kOrbPatchRadius_px; ++v) {
    const uint8_t* row = image.ptr<uint8_t>(y + v) + x;
    int sum = 0;
    for (int u = -kOrbPatchRadius_px; u <= kOrbPatchRadius_px; ++u) {
      if (u * u + v * v > kOrbPatchRadius_px * (kOrbPatchRadius_px + 1)) continue;
      moments[0] += u * row[u];
      sum += row[u];
    }
    moments[1] += v * sum;
  }
  return moments;
}

void ScalarBlur(const cv::Mat& image, cv::Mat& blurred) {
  const auto blend = [](int a, int b, int c, int d, int e, int f, int g) {
    return static_cast<uint8_t>((18 * (a + g) + 34 * (b + f) + 48 * (c + e) + 56 * d + 128) >> 8);
  };
  blurred.create(image.size(), CV_8UC1);
  std::vector<uint8_t> padded(static_cast<size_t>(image.cols) + 6);
  for (int y = 0; y < image.rows; ++y) {
    std::array<const uint8_t*, 7> r{};
    for (int k = 0; k < 7; ++k) {
      r[static_cast<size_t>(k)] = image.ptr<uint8_t>(std::clamp(y + k - 3, 0, image.rows - 1));
    }
    uint8_t* p = padded.data() + 3;
    for (int x = 0; x < image.cols; ++x) p[x] = blend(r[0][x], r[1][x], r[2][x], r[3][x], r[4][x], r[5][x], r[6][x]);
    for (int k = 1; k <= 3; ++k) {
      p[-k] = p[0];
      p[image.cols - 1 + k] = p[image.cols - 1];
    }
    uint8_t* out = blurred.ptr<uint8_t>(y);
    for (int x = 0; x < image.cols; ++x, ++p) out[x] = blend(p[-3], p[-2], p[-1], p[0], p[1], p[2], p[3]);
  }
}

void ScalarGradients(const cv::Mat& image, Gradients& out) {
  constexpr int kPad = 2;
  out.dx.create(image.size(), CV_16SC1);
  out.dy.create(image.size(), CV_16SC1);
  std::vector<int16_t> smooth(static_cast<size_t>(image.cols) + 2 * kPad), slope(smooth);
  for (int y = 0; y < image.rows; ++y) {
    std::array<const uint8_t*, 5> r{};
    for (int k = 0; k < 5; ++k) {
      r[static_cast<size_t>(k)] = image.ptr<uint8_t>(std::clamp(y + k - 2, 0, image.rows - 1));
    }
    int16_t* s = smooth.data() + kPad;
    int16_t* d = slope.data() + kPad;
    for (int x = 0; x < image.cols; ++x) {
      s[x] = static_cast<int16_t>(r[0][x] + r[4][x] + 4 * (r[1][x] + r[3][x]) + 6 * r[2][x]);
      d[x] = static_cast<int16_t>(r[4][x] - r[0][x] + 2 * (r[3][x] - r[1][x]));
    }
    for (int k = 1; k <= kPad; ++k) {
      s[-k] = s[0];
      d[-k] = d[0];
      s[image.cols - 1 + k] = s[image.cols - 1];
      d[image.cols - 1 + k] = d[image.cols - 1];
    }
    auto* dx = out.dx.ptr<int16_t>(y);
    auto* dy = out.dy.ptr<int16_t>(y);
    for (int x = 0; x < image.cols; ++x, ++s, ++d) {
      dx[x] = static_cast<int16_t>(s[2] - s[-2] + 2 * (s[1] - s[-1]));
      dy[x] = static_cast<int16_t>(d[-2] + d[2] + 4 * (d[-1] + d[1]) + 6 * d[0]);
    }
  }
}

void ScalarEdgeMap(const Gradients& gradients, int threshold, cv::Mat& out) {
  constexpr int kMargin = 2;
  out = cv::Mat::zeros(gradients.dx.size(), CV_8UC1);
  for (int y = kMargin; y < out.rows - kMargin; ++y) {
    const auto* dx = gradients.dx.ptr<int16_t>(y);
    const auto* dy = gradients.dy.ptr<int16_t>(y);
    const auto* up = gradients.dy.ptr<int16_t>(y - 1);
    const auto* down = gradients.dy.ptr<int16_t>(y + 1);
    uint8_t* marks = out.ptr<uint8_t>(y);
    for (int x = kMargin; x < out.cols - kMargin; ++x) {
      const int ax = std::abs(dx[x]), ay = std::abs(dy[x]);
      if (std::max(ax, ay) < threshold) continue;
      const bool steep = ax >= ay;
      if (steep && ax > std::abs(dx[x - 1]) && ax >= std::abs(dx[x + 1])) marks[x] = kSteepEdge;
      if (!steep && ay > std::abs(up[x]) && ay >= std::abs(down[x])) marks[x] = kFlatEdge;
    }
  }
}

std::array<LbdRow, kLbdRows> ScalarLbdRows(const Gradients& gradients, const Segment2& segment) {
  const auto fixed = [](double v, int bits) { return static_cast<int>(std::llround(v * (1 << bits))); };
  const int count = std::clamp(static_cast<int>(segment.Length()), 1, kLbdSamples);
  const Eigen::Vector2d direction = (segment.q - segment.p) / segment.Length();
  const Eigen::Vector2d step = (segment.q - segment.p) / count;
  const Eigen::Vector2d row(-direction.y(), direction.x());
  const Eigen::Vector2d start = segment.p + 0.5 * step - kLbdRows / 2 * row + Eigen::Vector2d(0.5, 0.5);
  const int x0 = fixed(start.x(), 16), y0 = fixed(start.y(), 16);
  const int step_x = fixed(step.x(), 16), step_y = fixed(step.y(), 16);
  const int row_x = fixed(row.x(), 16), row_y = fixed(row.y(), 16);
  const int cx = fixed(direction.x(), 14), cy = fixed(direction.y(), 14);
  const auto* dx = gradients.dx.ptr<int16_t>();
  const auto* dy = gradients.dy.ptr<int16_t>();
  const auto stride = static_cast<int>(gradients.dx.step1());
  std::array<LbdRow, kLbdRows> rows{};
  for (int r = 0; r < kLbdRows; ++r) {
    LbdRow& sums = rows[static_cast<size_t>(r)];
    for (int i = 0; i < count; ++i) {
      const int x = x0 + r * row_x + i * step_x, y = y0 + r * row_y + i * step_y;
      const int at = (y >> 16) * stride + (x >> 16);
      const int across = (cx * dy[at] - cy * dx[at]) >> 14;
      const int along = (cx * dx[at] + cy * dy[at]) >> 14;
      sums[0] += std::max(across, 0);
      sums[1] += std::max(-across, 0);
      sums[2] += std::max(along, 0);
      sums[3] += std::max(-along, 0);
    }
  }
  return rows;
}

std::vector<ScalarShrink::Place> ScalarShrink::Places(int from, int to) {
  std::vector<Place> places;
  for (int i = 0; i < to; ++i) {
    const auto place = static_cast<float>((i + 0.5) * (1.0 / (static_cast<double>(to) / from)) - 0.5);
    const int before = std::clamp(static_cast<int>(std::floor(place)), 0, from - 1);
    const float fraction = std::max(place - static_cast<float>(before), 0.0F);
    places.push_back({before, std::min(before + 1, from - 1), static_cast<int>(std::lrint(2048.0F * fraction))});
  }
  return places;
}

ScalarShrink::ScalarShrink(cv::Size from, cv::Size to)
    : columns_(Places(from.width, to.width)), rows_(Places(from.height, to.height)) {}

void ScalarShrink::Apply(const cv::Mat& image, cv::Mat& out) const {
  out.create(static_cast<int>(rows_.size()), static_cast<int>(columns_.size()), CV_8UC1);
  for (int y = 0; y < out.rows; ++y) {
    const Place& row = rows_[static_cast<size_t>(y)];
    const uint8_t* first = image.ptr<uint8_t>(row.first);
    const uint8_t* second = image.ptr<uint8_t>(row.second);
    uint8_t* pixels = out.ptr<uint8_t>(y);
    for (const Place& c : columns_) {
      const auto along = [&c](const uint8_t* r) {
        return (2048 * r[c.first] + c.weight * (r[c.second] - r[c.first])) >> 4;
      };
      const int above = along(first) * (2048 - row.weight) >> 16;
      const int below = along(second) * row.weight >> 16;
      *pixels++ = static_cast<uint8_t>((above + below + 2) >> 2);
    }
  }
}

int ScalarRowSearch(const cv::Mat& left, const cv::Mat& right, int u, int v, int n_places) {
  constexpr int kHalf = 5;
  constexpr int kPixels = 121;
  std::array<int, 11> column_sum{}, column_square{};
  double best = 0.0;
  int best_disparity = -1;
  int sum_left = 0;
  for (int y = -kHalf; y <= kHalf; ++y) {
    for (int x = -kHalf; x <= kHalf; ++x) sum_left += left.ptr<uint8_t>(v + y)[u + x];
  }
  // From right to left: a window has one new column.
  int sum = 0, square = 0;
  for (int x = u + kHalf, seen = 0; seen < n_places + 2 * kHalf; --x, ++seen) {
    const auto slot = static_cast<size_t>(seen % 11);
    sum -= column_sum[slot];
    square -= column_square[slot];
    column_sum[slot] = column_square[slot] = 0;
    for (int y = -kHalf; y <= kHalf; ++y) {
      const int pixel = right.ptr<uint8_t>(v + y)[x];
      column_sum[slot] += pixel;
      column_square[slot] += pixel * pixel;
    }
    sum += column_sum[slot];
    square += column_square[slot];
    if (seen < 2 * kHalf) continue;
    int product = 0;
    for (int y = -kHalf; y <= kHalf; ++y) {
      const uint8_t* a = left.ptr<uint8_t>(v + y) + u - kHalf;
      const uint8_t* b = right.ptr<uint8_t>(v + y) + x;
      for (int i = 0; i <= 2 * kHalf; ++i) product += a[i] * b[i];
    }
    const double mean = static_cast<double>(sum) / kPixels;
    const double cross = product - mean * sum_left;
    const double energy = square - mean * sum;
    const double score = cross > 0.0 && energy > 0.0 ? cross * cross / energy : 0.0;
    if (score <= best) continue;
    best = score;
    best_disparity = seen - 2 * kHalf;
  }
  return best_disparity;
}

}  // namespace plslam::test
