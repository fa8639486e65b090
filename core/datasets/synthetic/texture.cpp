// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/texture.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace plslam::synthetic {
namespace {

// Fixed point of the stored values: 8 bits before the point, 8 after it.
constexpr float kScale = 256.0F;
// A footprint longer than this many times its width is treated as wider.
constexpr float kMaxAnisotropy = 4.0F;
// Share of a level, on either side, over which only that level is used; the next one is blended in between.
constexpr float kPureShare = 0.2F;

/// Piecewise linear approximation of log2, exact at powers of two: exponent plus fraction of a float.
float FastLog2(float x) {
  const auto bits = std::bit_cast<uint32_t>(x);
  return static_cast<float>(bits) * (1.0F / (1U << 23)) - 127.0F;
}

int FloorToInt(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (x < static_cast<float>(truncated) ? 1 : 0);
}

}  // namespace

Texture::Texture(int width, int height, Border border, const std::vector<float>& pixels) : border_(border) {
  Level finest{width, height, std::vector<uint16_t>(pixels.size())};
  std::transform(pixels.begin(), pixels.end(), finest.pixels.begin(), [](float value) {
    return static_cast<uint16_t>(std::floor(std::clamp(value, 0.0F, 255.0F) * kScale + 0.5F));
  });
  levels_.push_back(std::move(finest));
  while (levels_.back().width > 1 && levels_.back().height > 1) {
    levels_.push_back(Halved(levels_.back()));
  }
}

Texture::Level Texture::Halved(const Level& level) {
  Level half{level.width / 2, level.height / 2, {}};
  half.pixels.resize(static_cast<size_t>(half.width) * half.height);
  for (int y = 0; y < half.height; ++y) {
    const uint16_t* top = &level.pixels[static_cast<size_t>(2 * y) * level.width];
    const uint16_t* bottom = top + level.width;
    for (int x = 0; x < half.width; ++x) {
      const int sum = top[2 * x] + top[2 * x + 1] + bottom[2 * x] + bottom[2 * x + 1];
      half.pixels[static_cast<size_t>(y) * half.width + x] = static_cast<uint16_t>((sum + 2) / 4);
    }
  }
  return half;
}

float Texture::Bilinear(const Level& level, float u, float v, float scale) const {
  const float x = u * scale - 0.5F;
  const float y = v * scale - 0.5F;
  int x0 = FloorToInt(x);
  int y0 = FloorToInt(y);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  int x1 = x0 + 1;
  int y1 = y0 + 1;
  if (border_ == Border::kRepeat) {
    x0 &= level.width - 1;
    x1 &= level.width - 1;
    y0 &= level.height - 1;
    y1 &= level.height - 1;
  } else {
    x0 = std::clamp(x0, 0, level.width - 1);
    x1 = std::clamp(x1, 0, level.width - 1);
    y0 = std::clamp(y0, 0, level.height - 1);
    y1 = std::clamp(y1, 0, level.height - 1);
  }
  const uint16_t* top = level.pixels.data() + static_cast<size_t>(y0) * level.width;
  const uint16_t* bottom = level.pixels.data() + static_cast<size_t>(y1) * level.width;
  const float a = static_cast<float>(top[x0]) + fx * static_cast<float>(top[x1] - top[x0]);
  const float b = static_cast<float>(bottom[x0]) + fx * static_cast<float>(bottom[x1] - bottom[x0]);
  return (a + fy * (b - a)) * (1.0F / kScale);
}

float Texture::Trilinear(float u, float v, float level) const {
  if (level <= kPureShare) {
    return Bilinear(levels_[0], u, v, 1.0F);
  }
  const int last = static_cast<int>(levels_.size()) - 1;
  const int fine = std::min(static_cast<int>(level), last);
  const float scale = 1.0F / static_cast<float>(1U << fine);
  const float share = (level - static_cast<float>(fine) - kPureShare) * (1.0F / (1.0F - 2.0F * kPureShare));
  if (share <= 0.0F || fine == last) {
    return Bilinear(levels_[fine], u, v, scale);
  }
  const float coarse = Bilinear(levels_[fine + 1], u, v, 0.5F * scale);
  if (share >= 1.0F) {
    return coarse;
  }
  const float a = Bilinear(levels_[fine], u, v, scale);
  return a + share * (coarse - a);
}

float Texture::Sample(float u, float v, const Footprint& fp) const {
  const float along_x = fp.du_dx * fp.du_dx + fp.dv_dx * fp.dv_dx;
  const float along_y = fp.du_dy * fp.du_dy + fp.dv_dy * fp.dv_dy;
  const bool x_is_major = along_x >= along_y;
  const float major = x_is_major ? along_x : along_y;
  if (major <= 1.0F) {
    return Bilinear(levels_[0], u, v, 1.0F);
  }
  // Squares of lengths throughout. One tap is as wide as the geometric mean of its two axes.
  const float minor = std::max(x_is_major ? along_y : along_x, major * (1.0F / (kMaxAnisotropy * kMaxAnisotropy)));
  if (major < 4.0F * minor) {
    return Trilinear(u, v, 0.25F * FastLog2(major * minor));
  }
  const float level = 0.25F * FastLog2(0.25F * major * minor);
  const float du = 0.25F * (x_is_major ? fp.du_dx : fp.du_dy);
  const float dv = 0.25F * (x_is_major ? fp.dv_dx : fp.dv_dy);
  return 0.5F * (Trilinear(u - du, v - dv, level) + Trilinear(u + du, v + dv, level));
}

}  // namespace plslam::synthetic
