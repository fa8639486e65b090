// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace plslam::synthetic {

/// Derivatives of texture coordinates by the pixel column and row, in texels of the finest level.
struct Footprint {
  float du_dx = 0.0F;
  float dv_dx = 0.0F;
  float du_dy = 0.0F;
  float dv_dy = 0.0F;
};

/// A grey texture with its mip-maps (2x2 means, centres aligned, so that no level is shifted against another). Sides
/// are powers of two.
class Texture {
 public:
  enum class Border { kRepeat, kClamp };

  /// `pixels` holds width * height values of 0..255, row by row.
  Texture(int width, int height, Border border, const std::vector<float>& pixels);

  int width() const { return levels_.front().width; }
  int height() const { return levels_.front().height; }

  /// Value (0..255) over the footprint of one pixel at (u, v), in texels; texel (0, 0) covers [0,1]x[0,1]. Trilinear,
  /// with two taps along the longer axis of the footprint if it is at least twice the shorter one.
  float Sample(float u, float v, const Footprint& footprint) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<uint16_t> pixels;
  };

  static Level Halved(const Level& level);
  float Trilinear(float u, float v, float level) const;
  float Bilinear(const Level& level, float u, float v, float scale) const;

  Border border_;
  std::vector<Level> levels_;
};

}  // namespace plslam::synthetic
