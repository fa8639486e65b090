// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/datasets/synthetic/exact_math.h"
#include "core/datasets/synthetic/texture.h"

namespace plslam::synthetic {

/// A picture being painted: grey values 0..255 in texels, (0, 0) at the top left. Shapes are anti-aliased.
class Canvas {
 public:
  Canvas(int width, int height, float value)
      : width_(width), height_(height), pixels_(static_cast<size_t>(width) * height, value) {}

  int width() const { return width_; }
  int height() const { return height_; }
  float& At(int x, int y) { return pixels_[static_cast<size_t>(y) * width_ + x]; }

  /// Adds value noise: `octaves` of random grids, the first with cells of `cell` texels (a power of two) and
  /// `amplitude` to both sides, each next with half of both. Repeats at the borders.
  void AddNoise(uint64_t seed, int cell, float amplitude, int octaves);
  /// Fills the axis-parallel rectangle [x0,x1) x [y0,y1), cut at the borders.
  void Rectangle(double x0, double y0, double x1, double y1, float value);
  void Disc(double x, double y, double radius, float value);
  /// A rectangle about (x, y) turned by `angle`.
  void TurnedRectangle(double x, double y, double half_length, double half_width, double angle, float value);
  void Triangle(const std::array<std::array<double, 2>, 3>& corners, float value);
  /// A letter-like pattern: random cells of a 4x6 grid joined by strokes.
  void Glyph(Random& random, double x, double y, double size, float value);
  /// Adds a soft stripe from a to b: `amplitude` at its middle, fading to zero over `fade` of its length at both ends;
  /// `half_width` in texels with edges `softness` texels wide.
  void SoftStripe(std::array<double, 2> a, std::array<double, 2> b, double half_width, double softness, double fade,
                  float amplitude);

  Texture ToTexture(Texture::Border border) const { return Texture(width_, height_, border, pixels_); }

 private:
  /// A half plane: a * x + b * y + c >= 0 inside, (a, b) of unit length.
  struct HalfPlane {
    double a = 0.0;
    double b = 0.0;
    double c = 0.0;
  };
  template <size_t N>
  void FillConvex(const std::array<HalfPlane, N>& sides, double x0, double y0, double x1, double y1, float value);

  int width_;
  int height_;
  std::vector<float> pixels_;
};

}  // namespace plslam::synthetic
