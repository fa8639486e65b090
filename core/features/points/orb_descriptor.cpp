// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/points/orb_descriptor.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "core/features/image/vector_kernels.h"

namespace plslam {
namespace {

/// Pixels of a row that vector code processes at once.
constexpr int kBlurBlock = 32;
constexpr int kPatchRow = 32;  // 31 pixels and one of weight 0, for whole vector registers

/// Weights of the disc: 1 inside, and the column inside.
struct DiscWeights {
  std::array<std::array<int16_t, kPatchRow>, 2 * kOrbPatchRadius_px + 1> inside{};
  std::array<std::array<int16_t, kPatchRow>, 2 * kOrbPatchRadius_px + 1> column{};
};

constexpr DiscWeights MakeDiscWeights() {
  DiscWeights w;
  constexpr int kR = kOrbPatchRadius_px;
  for (int v = -kR; v <= kR; ++v) {
    for (int u = -kR; u <= kR; ++u) {
      if (u * u + v * v > kR * kR + kR) continue;  // (r + 1/2)^2, rounded down: a round disc
      w.inside[v + kR][u + kR] = 1;
      w.column[v + kR][u + kR] = static_cast<int16_t>(u);
    }
  }
  return w;
}
constexpr DiscWeights kDisc = MakeDiscWeights();

struct Moments {
  int m10 = 0;
  int m01 = 0;
};

/// First moments of the disc whose bounding box begins at `corner`. Reads kPatchRow pixels of each row.
PLSLAM_AVX2_CLONES
Moments DiscMoments(const uint8_t* corner, size_t step) {
  Moments m;
  for (int v = 0; v <= 2 * kOrbPatchRadius_px; ++v) {
    const uint8_t* row = corner + v * step;
    int sum = 0;
    int sum_u = 0;
    for (int u = 0; u < kPatchRow; ++u) {
      const auto pixel = static_cast<int16_t>(row[u]);
      sum += pixel * kDisc.inside[v][u];
      sum_u += pixel * kDisc.column[v][u];
    }
    m.m10 += sum_u;
    m.m01 += sum * (v - kOrbPatchRadius_px);
  }
  return m;
}

/// atan2 by arithmetic alone, because that of the C library may differ between processors. Error below 1e-5 rad.
float Atan2(int y, int x) {
  if (x == 0 && y == 0) return 0.0F;
  const double ax = std::abs(x);
  const double ay = std::abs(y);
  const double t = std::min(ax, ay) / std::max(ax, ay);
  const double t2 = t * t;
  // Odd polynomial fitted to atan on [0, 1] (Hastings 1955, sheet 11).
  double angle = t * (0.9998660 + t2 * (-0.3302995 + t2 * (0.1801410 + t2 * (-0.0851330 + t2 * 0.0208351))));
  if (ay > ax) angle = std::numbers::pi / 2 - angle;
  if (x < 0) angle = std::numbers::pi - angle;
  return static_cast<float>(y < 0 ? -angle : angle);
}

/// SplitMix64: small, seeded, the same everywhere.
class SplitMix {
 public:
  explicit SplitMix(uint64_t seed) : state_(seed) {}
  uint64_t Next() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  /// Standard normal as a sum of twelve uniform numbers, without library functions that could differ.
  double Normal() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(Next() >> 11) * 0x1.0p-53;
    return sum;
  }

 private:
  uint64_t state_;
};

int SquaredDistance(const BriefTest& t) { return (t.x0 - t.x1) * (t.x0 - t.x1) + (t.y0 - t.y1) * (t.y0 - t.y1); }

BriefPattern MakePattern() {
  constexpr double kSigma_px = 31.0 / 5.0;               // G-II: variance of patch size^2 / 25
  constexpr int kMaxRadius_px = kOrbPatchRadius_px - 1;  // rounding of turned places may add one
  SplitMix random(20110611);
  const auto draw = [&](int8_t& x, int8_t& y) {
    int px = 0;
    int py = 0;
    do {
      px = static_cast<int>(std::floor(random.Normal() * kSigma_px + 0.5));
      py = static_cast<int>(std::floor(random.Normal() * kSigma_px + 0.5));
    } while (px * px + py * py > kMaxRadius_px * kMaxRadius_px);
    x = static_cast<int8_t>(px);
    y = static_cast<int8_t>(py);
  };
  BriefPattern pattern;
  for (BriefTest& test : pattern) {
    do {
      draw(test.x0, test.y0);
      draw(test.x1, test.y1);
      // Nearer pairs could coincide when rotated and rounded.
    } while (SquaredDistance(test) < 4);
  }
  return pattern;
}

std::array<BriefPattern, kOrbAngleBins> MakeTurnedPatterns() {
  const BriefPattern base = MakePattern();
  std::array<BriefPattern, kOrbAngleBins> turned;
  for (int bin = 0; bin < kOrbAngleBins; ++bin) {
    const double angle = 2.0 * std::numbers::pi * bin / kOrbAngleBins;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const auto turn = [c, s](int x, int y, int8_t& turned_x, int8_t& turned_y) {
      // A small offset, so that exact halves are rounded equally whatever the last bit of the cosine.
      turned_x = static_cast<int8_t>(std::floor(c * x - s * y + 0.5 + 1e-9));
      turned_y = static_cast<int8_t>(std::floor(s * x + c * y + 0.5 + 1e-9));
    };
    for (size_t i = 0; i < base.size(); ++i) {
      turn(base[i].x0, base[i].y0, turned[bin][i].x0, turned[bin][i].y0);
      turn(base[i].x1, base[i].y1, turned[bin][i].x1, turned[bin][i].y1);
    }
  }
  return turned;
}

/// One row of the vertical pass: weighted sum of seven rows.
PLSLAM_AVX2_CLONES
void BlurColumns(const std::array<const uint8_t*, 7>& rows, int width, uint8_t* out) {
  const uint8_t* r0 = rows[0];
  const uint8_t* r1 = rows[1];
  const uint8_t* r2 = rows[2];
  const uint8_t* r3 = rows[3];
  const uint8_t* r4 = rows[4];
  const uint8_t* r5 = rows[5];
  const uint8_t* r6 = rows[6];
  for (int x = 0; x < width; ++x) {
    // Weights sum to 256, so the sum fits 16 bits.
    const auto sum =
        static_cast<uint16_t>(18 * (r0[x] + r6[x]) + 34 * (r1[x] + r5[x]) + 48 * (r2[x] + r4[x]) + 56 * r3[x] + 128);
    out[x] = static_cast<uint8_t>(sum >> 8);
  }
}

/// The same along a row that has three more pixels on either side.
PLSLAM_AVX2_CLONES
void BlurRow(const uint8_t* padded, int width, uint8_t* out) {
  for (int x = 0; x < width; ++x) {
    const uint8_t* p = padded + x;
    const auto sum =
        static_cast<uint16_t>(18 * (p[0] + p[6]) + 34 * (p[1] + p[5]) + 48 * (p[2] + p[4]) + 56 * p[3] + 128);
    out[x] = static_cast<uint8_t>(sum >> 8);
  }
}

}  // namespace

float IntensityCentroidAngle(const cv::Mat& image, int x, int y) {
  const uint8_t* corner = image.ptr<uint8_t>(y - kOrbPatchRadius_px) + x - kOrbPatchRadius_px;
  const Moments m = DiscMoments(corner, image.step);
  return Atan2(m.m01, m.m10);
}

int AngleBin(float angle_rad) {
  const double turns = static_cast<double>(angle_rad) / (2.0 * std::numbers::pi);
  const int bin = static_cast<int>(std::floor(turns * kOrbAngleBins + 0.5));
  return ((bin % kOrbAngleBins) + kOrbAngleBins) % kOrbAngleBins;
}

const BriefPattern& TurnedPattern(int bin) {
  static const std::array<BriefPattern, kOrbAngleBins> kPatterns = MakeTurnedPatterns();
  return kPatterns[bin];
}

void OrbDescriptor::PrepareOffsets(size_t step) {
  step_ = step;
  offsets_.clear();
  for (int bin = 0; bin < kOrbAngleBins; ++bin) {
    for (const BriefTest& t : TurnedPattern(bin)) {
      offsets_.push_back(t.y0 * static_cast<int>(step) + t.x0);
      offsets_.push_back(t.y1 * static_cast<int>(step) + t.x1);
    }
  }
}

Descriptor OrbDescriptor::Compute(const cv::Mat& blurred, int x, int y, int bin) {
  if (blurred.step != step_) PrepareOffsets(blurred.step);
  const uint8_t* center = blurred.ptr<uint8_t>(y) + x;
  const int* offset = offsets_.data() + static_cast<size_t>(bin) * 512;
  Descriptor descriptor{};
  for (uint64_t& word : descriptor) {
    uint64_t bits = 0;
    for (int i = 0; i < 64; ++i, offset += 2) {
      bits |= static_cast<uint64_t>(center[offset[0]] < center[offset[1]]) << i;
    }
    word = bits;
  }
  return descriptor;
}

void BlurForBrief(const cv::Mat& image, cv::Mat& blurred) {
  blurred.create(image.size(), CV_8UC1);
  const int width = image.cols;
  std::vector<uint8_t> padded(static_cast<size_t>(width) + 6);
  for (int y = 0; y < image.rows; ++y) {
    std::array<const uint8_t*, 7> rows{};
    for (int k = 0; k < 7; ++k) rows[k] = image.ptr<uint8_t>(std::clamp(y + k - 3, 0, image.rows - 1));
    InWholeBlocks<kBlurBlock>(width, [&](int begin, int n) {
      std::array<const uint8_t*, 7> from{};
      for (int k = 0; k < 7; ++k) from[k] = rows[k] + begin;
      BlurColumns(from, n, padded.data() + 3 + begin);
    });
    for (int k = 0; k < 3; ++k) {
      padded[k] = padded[3];
      padded[width + 3 + k] = padded[width + 2];
    }
    auto* out = blurred.ptr<uint8_t>(y);
    InWholeBlocks<kBlurBlock>(width, [&](int begin, int n) { BlurRow(padded.data() + begin, n, out + begin); });
  }
}

}  // namespace plslam
