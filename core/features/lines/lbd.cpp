// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/lbd.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/features/image/vector_kernels.h"

namespace plslam {
namespace {

constexpr int kPlaceBits = 16;
constexpr int kAxisBits = 14;
constexpr int kHalfRows = kLbdRows / 2;
constexpr size_t kSampleCount = size_t{kLbdRows} * kLbdSamples;
static_assert(kLbdRows % 2 == 1 && kLbdBandWidth % 2 == 1, "rows and bands have a middle");

/// Gradients at the sample points of all rows, row by row.
struct Samples {
  int count = 0;
  alignas(32) std::array<int16_t, kSampleCount> dx;
  alignas(32) std::array<int16_t, kSampleCount> dy;
};

/// Pixel positions with 16 fractional bits: the first sample of the first row, and the steps to the next sample and
/// row.
struct Lattice {
  int64_t x, y, step_x, step_y, row_x, row_y;
};

int64_t Fixed(double v, int bits) { return std::llround(v * static_cast<double>(int64_t{1} << bits)); }

Lattice MakeLattice(const Segment2& segment, const Eigen::Vector2d& direction, int count) {
  const Eigen::Vector2d step = (segment.q - segment.p) / count;
  const Eigen::Vector2d row(-direction.y(), direction.x());
  // Half a pixel is added, so that truncation rounds.
  const Eigen::Vector2d start = segment.p + 0.5 * step - kHalfRows * row + Eigen::Vector2d(0.5, 0.5);
  return {Fixed(start.x(), kPlaceBits), Fixed(start.y(), kPlaceBits), Fixed(step.x(), kPlaceBits),
          Fixed(step.y(), kPlaceBits),  Fixed(row.x(), kPlaceBits),   Fixed(row.y(), kPlaceBits)};
}

bool IsInside(const Lattice& l, int count, int width, int height) {
  if (width > INT16_MAX || height > INT16_MAX) return false;
  for (const int64_t i : {0, count - 1}) {
    for (const int64_t r : {0, kLbdRows - 1}) {
      const int64_t x = (l.x + i * l.step_x + r * l.row_x) >> kPlaceBits;
      const int64_t y = (l.y + i * l.step_y + r * l.row_y) >> kPlaceBits;
      if (x < 0 || y < 0 || x >= width || y >= height) return false;
    }
  }
  return true;
}

/// Indices of the samples of all rows in the image, `y * stride + x`, row by row.
PLSLAM_AVX2_CLONES void Places(int x0, int y0, int step_x, int step_y, int row_x, int row_y, int stride, int count,
                               int32_t* __restrict places) {
  for (int r = 0; r < kLbdRows; ++r) {
    const int x = x0 + r * row_x;
    const int y = y0 + r * row_y;
    for (int i = 0; i < count; ++i) {
      places[i] = ((y + i * step_y) >> kPlaceBits) * stride + ((x + i * step_x) >> kPlaceBits);
    }
    places += count;
  }
}

void GatherInside(const Gradients& g, const Lattice& l, Samples& out) {
  const int16_t* dx = g.dx.ptr<int16_t>();
  const int16_t* dy = g.dy.ptr<int16_t>();
  std::array<int32_t, kSampleCount> places;
  Places(static_cast<int>(l.x), static_cast<int>(l.y), static_cast<int>(l.step_x), static_cast<int>(l.step_y),
         static_cast<int>(l.row_x), static_cast<int>(l.row_y), static_cast<int>(g.dx.step1()), out.count,
         places.data());
  const size_t size = size_t{kLbdRows} * static_cast<size_t>(out.count);
  for (size_t k = 0; k < size; ++k) {
    out.dx[k] = dx[places[k]];
    out.dy[k] = dy[places[k]];
  }
}

void GatherClamped(const Gradients& g, const Lattice& l, Samples& out) {
  size_t k = 0;
  for (int r = 0; r < kLbdRows; ++r) {
    for (int i = 0; i < out.count; ++i, ++k) {
      const int64_t x = (l.x + i * l.step_x + r * l.row_x) >> kPlaceBits;
      const int64_t y = (l.y + i * l.step_y + r * l.row_y) >> kPlaceBits;
      const int column = static_cast<int>(std::clamp<int64_t>(x, 0, g.dx.cols - 1));
      const int row = static_cast<int>(std::clamp<int64_t>(y, 0, g.dx.rows - 1));
      out.dx[k] = g.dx.at<int16_t>(row, column);
      out.dy[k] = g.dy.at<int16_t>(row, column);
    }
  }
}

/// Sums `count` gradients rotated into the segment's frame, whose direction is (cx, cy) with 14 fractional bits.
PLSLAM_AVX2_CLONES void SumRow(const int16_t* dx, const int16_t* dy, int count, int16_t cx, int16_t cy,
                               int32_t* sums) {
  int32_t across_all = 0;
  int32_t across_positive = 0;
  int32_t along_all = 0;
  int32_t along_positive = 0;
  for (int i = 0; i < count; ++i) {
    const int32_t across = (cx * dy[i] - cy * dx[i]) >> kAxisBits;
    const int32_t along = (cx * dx[i] + cy * dy[i]) >> kAxisBits;
    across_all += across;
    across_positive += across > 0 ? across : 0;
    along_all += along;
    along_positive += along > 0 ? along : 0;
  }
  sums[0] = across_positive;
  sums[1] = across_positive - across_all;
  sums[2] = along_positive;
  sums[3] = along_positive - along_all;
}

/// Writes one bit per channel, starting at `bit`: whether the first is larger.
void Compare(const std::array<int64_t, kLbdChannels>& a, const std::array<int64_t, kLbdChannels>& b, size_t& bit,
             Descriptor& out) {
  for (size_t c = 0; c < kLbdChannels; ++c, ++bit) {
    out[bit / 64] |= static_cast<uint64_t>(a[c] > b[c]) << (bit % 64);
  }
}

}  // namespace

std::array<LbdRow, kLbdRows> LbdRows(const Gradients& gradients, const Segment2& segment) {
  std::array<LbdRow, kLbdRows> rows{};
  const double length = segment.Length();
  if (gradients.dx.empty() || !(length > 0.0) || !(length < 1e5)) return rows;
  const Eigen::Vector2d direction = (segment.q - segment.p) / length;
  Samples samples;
  samples.count = std::clamp(static_cast<int>(length), 1, kLbdSamples);
  const Lattice lattice = MakeLattice(segment, direction, samples.count);
  if (IsInside(lattice, samples.count, gradients.dx.cols, gradients.dx.rows)) {
    GatherInside(gradients, lattice, samples);
  } else {
    GatherClamped(gradients, lattice, samples);
  }
  const auto cx = static_cast<int16_t>(Fixed(direction.x(), kAxisBits));
  const auto cy = static_cast<int16_t>(Fixed(direction.y(), kAxisBits));
  for (size_t r = 0; r < kLbdRows; ++r) {
    const size_t first = r * static_cast<size_t>(samples.count);
    SumRow(&samples.dx[first], &samples.dy[first], samples.count, cx, cy, rows[r].data());
  }
  return rows;
}

std::array<LbdBand, kLbdBands> LbdBands(const std::array<LbdRow, kLbdRows>& rows) {
  std::array<std::array<int64_t, kLbdChannels>, kLbdRows> weighted{};
  for (int r = 0; r < kLbdRows; ++r) {
    const int64_t weight = 2 * kHalfRows - std::abs(r - kHalfRows);
    for (size_t c = 0; c < kLbdChannels; ++c) {
      weighted[static_cast<size_t>(r)][c] = (weight * rows[static_cast<size_t>(r)][c]) >> 6;
    }
  }
  std::array<LbdBand, kLbdBands> bands{};
  for (int band = 0; band < kLbdBands; ++band) {
    const int middle = band * kLbdBandWidth + kLbdBandWidth / 2;
    constexpr int kReach = kLbdBandWidth + kLbdBandWidth / 2;
    constexpr int64_t kAllWeights = (kReach + 1) * (kReach + 1);
    int64_t total = 0;
    std::array<int64_t, kLbdChannels> sum{};
    std::array<int64_t, kLbdChannels> squares{};
    for (int r = std::max(0, middle - kReach); r <= std::min(kLbdRows - 1, middle + kReach); ++r) {
      const int64_t weight = kReach + 1 - std::abs(r - middle);
      total += weight;
      for (size_t c = 0; c < kLbdChannels; ++c) {
        const int64_t v = weighted[static_cast<size_t>(r)][c];
        sum[c] += weight * v;
        squares[c] += weight * v * v;
      }
    }
    LbdBand& out = bands[static_cast<size_t>(band)];
    for (size_t c = 0; c < kLbdChannels; ++c) {
      const int64_t spread = squares[c] * total - sum[c] * sum[c];
      // Division by a constant is a shift; only the outermost bands have fewer rows.
      out.mean[c] = total == kAllWeights ? sum[c] / kAllWeights : sum[c] / total;
      out.variance[c] = total == kAllWeights ? spread / (kAllWeights * kAllWeights) : spread / (total * total);
    }
  }
  return bands;
}

Descriptor LbdBits(const std::array<LbdBand, kLbdBands>& bands) {
  Descriptor out{};
  size_t bit = 0;
  for (size_t i = 0; i < kLbdBands; ++i) {
    for (size_t j = i + 1; j < kLbdBands; ++j) {
      Compare(bands[i].mean, bands[j].mean, bit, out);
      if (j > i + 1) Compare(bands[i].variance, bands[j].variance, bit, out);
    }
  }
  return out;
}

Descriptor ComputeLbd(const Gradients& gradients, const Segment2& segment) {
  return LbdBits(LbdBands(LbdRows(gradients, segment)));
}

}  // namespace plslam
