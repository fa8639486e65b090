// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/canvas.h"

#include <algorithm>

namespace plslam::synthetic {
namespace {

float Lattice(uint64_t seed, int x, int y) {
  const uint64_t bits = Hash(seed, static_cast<uint64_t>(x), static_cast<uint64_t>(y));
  return static_cast<float>(bits >> 40) * (2.0F / (1 << 24)) - 1.0F;
}

float Mixed(float a, float b, float share) { return a + share * (b - a); }

}  // namespace

void Canvas::AddNoise(uint64_t seed, int cell, float amplitude, int octaves) {
  for (int octave = 0; octave < octaves && cell >= 1; ++octave, cell /= 2, amplitude *= 0.5F) {
    const int columns = std::max(width_ / cell, 1);
    const int rows = std::max(height_ / cell, 1);
    const uint64_t octave_seed = Hash(seed, static_cast<uint64_t>(octave));
    std::vector<float> grid(static_cast<size_t>(columns) * rows);
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) {
        grid[static_cast<size_t>(y) * columns + x] = amplitude * Lattice(octave_seed, x, y);
      }
    }
    for (int y = 0; y < height_; ++y) {
      const auto fy = static_cast<float>(Smoothstep(static_cast<double>(y % cell) / cell));
      const float* top = &grid[static_cast<size_t>(y / cell % rows) * columns];
      const float* bottom = &grid[static_cast<size_t>((y / cell + 1) % rows) * columns];
      for (int x = 0; x < width_; ++x) {
        const auto fx = static_cast<float>(Smoothstep(static_cast<double>(x % cell) / cell));
        const int x0 = x / cell % columns;
        const int x1 = (x / cell + 1) % columns;
        At(x, y) += Mixed(Mixed(top[x0], top[x1], fx), Mixed(bottom[x0], bottom[x1], fx), fy);
      }
    }
  }
}

void Canvas::Rectangle(double x0, double y0, double x1, double y1, float value) {
  const int first_x = std::max(0, static_cast<int>(std::floor(x0)));
  const int last_x = std::min(width_ - 1, static_cast<int>(std::ceil(x1)) - 1);
  const int first_y = std::max(0, static_cast<int>(std::floor(y0)));
  const int last_y = std::min(height_ - 1, static_cast<int>(std::ceil(y1)) - 1);
  for (int y = first_y; y <= last_y; ++y) {
    const double cover_y = std::min(y1, y + 1.0) - std::max(y0, static_cast<double>(y));
    for (int x = first_x; x <= last_x; ++x) {
      const double cover_x = std::min(x1, x + 1.0) - std::max(x0, static_cast<double>(x));
      At(x, y) = Mixed(At(x, y), value, static_cast<float>(cover_x * cover_y));
    }
  }
}

void Canvas::Disc(double x, double y, double radius, float value) {
  const int first_x = std::max(0, static_cast<int>(x - radius - 1));
  const int last_x = std::min(width_ - 1, static_cast<int>(x + radius + 1));
  const int first_y = std::max(0, static_cast<int>(y - radius - 1));
  const int last_y = std::min(height_ - 1, static_cast<int>(y + radius + 1));
  for (int iy = first_y; iy <= last_y; ++iy) {
    for (int ix = first_x; ix <= last_x; ++ix) {
      const double dx = ix + 0.5 - x;
      const double dy = iy + 0.5 - y;
      const double cover = std::clamp(radius - std::sqrt(dx * dx + dy * dy) + 0.5, 0.0, 1.0);
      At(ix, iy) = Mixed(At(ix, iy), value, static_cast<float>(cover));
    }
  }
}

template <size_t N>
void Canvas::FillConvex(const std::array<HalfPlane, N>& sides, double x0, double y0, double x1, double y1,
                        float value) {
  const int first_x = std::max(0, static_cast<int>(x0) - 1);
  const int last_x = std::min(width_ - 1, static_cast<int>(x1) + 1);
  const int first_y = std::max(0, static_cast<int>(y0) - 1);
  const int last_y = std::min(height_ - 1, static_cast<int>(y1) + 1);
  for (int y = first_y; y <= last_y; ++y) {
    for (int x = first_x; x <= last_x; ++x) {
      double cover = 1.0;
      for (const HalfPlane& side : sides) {
        cover *= std::clamp(side.a * (x + 0.5) + side.b * (y + 0.5) + side.c + 0.5, 0.0, 1.0);
      }
      At(x, y) = Mixed(At(x, y), value, static_cast<float>(cover));
    }
  }
}

void Canvas::TurnedRectangle(double x, double y, double half_length, double half_width, double angle, float value) {
  const double c = Cos(angle);
  const double s = Sin(angle);
  const double along = c * x + s * y;
  const double across = -s * x + c * y;
  const std::array<HalfPlane, 4> sides = {
      HalfPlane{c, s, half_length - along}, HalfPlane{-c, -s, half_length + along},
      HalfPlane{-s, c, half_width - across}, HalfPlane{s, -c, half_width + across}};
  const double reach = half_length + half_width;
  FillConvex(sides, x - reach, y - reach, x + reach, y + reach, value);
}

void Canvas::Triangle(const std::array<std::array<double, 2>, 3>& corners, float value) {
  std::array<HalfPlane, 3> sides;
  for (int i = 0; i < 3; ++i) {
    const auto& p = corners[i];
    const auto& q = corners[(i + 1) % 3];
    const auto& r = corners[(i + 2) % 3];
    double a = p[1] - q[1];
    double b = q[0] - p[0];
    const double length = std::sqrt(a * a + b * b) + 1e-12;
    const double sign = a * (r[0] - p[0]) + b * (r[1] - p[1]) < 0.0 ? -1.0 : 1.0;
    a *= sign / length;
    b *= sign / length;
    sides[i] = {a, b, -(a * p[0] + b * p[1])};
  }
  FillConvex(sides, std::min({corners[0][0], corners[1][0], corners[2][0]}),
             std::min({corners[0][1], corners[1][1], corners[2][1]}),
             std::max({corners[0][0], corners[1][0], corners[2][0]}),
             std::max({corners[0][1], corners[1][1], corners[2][1]}), value);
}

void Canvas::Glyph(Random& random, double x, double y, double size, float value) {
  const double cell = size / 6.0;
  for (int stroke = 0; stroke < 4; ++stroke) {
    const int column = random.Int(4);
    const int row = random.Int(6);
    if (random.Chance(0.5)) {
      const int length = 2 + random.Int(4);
      Rectangle(x + column * cell, y + row * cell, x + (column + 1) * cell, y + std::min(row + length, 6) * cell,
                value);
    } else {
      Rectangle(x, y + row * cell, x + (2 + random.Int(3)) * cell, y + (row + 1) * cell, value);
    }
  }
}

void Canvas::SoftStripe(std::array<double, 2> a, std::array<double, 2> b, double half_width, double softness,
                        double fade, float amplitude) {
  const double dx = b[0] - a[0];
  const double dy = b[1] - a[1];
  const double length = std::sqrt(dx * dx + dy * dy);
  const double reach = half_width + softness + 1.0;
  const int first_x = std::max(0, static_cast<int>(std::min(a[0], b[0]) - reach));
  const int last_x = std::min(width_ - 1, static_cast<int>(std::max(a[0], b[0]) + reach));
  const int first_y = std::max(0, static_cast<int>(std::min(a[1], b[1]) - reach));
  const int last_y = std::min(height_ - 1, static_cast<int>(std::max(a[1], b[1]) + reach));
  for (int y = first_y; y <= last_y; ++y) {
    for (int x = first_x; x <= last_x; ++x) {
      const double px = x + 0.5 - a[0];
      const double py = y + 0.5 - a[1];
      const double along = (px * dx + py * dy) / (length * length);
      const double across = std::abs(px * dy - py * dx) / length;
      const double ends = Smoothstep(along / fade) * Smoothstep((1.0 - along) / fade);
      const double profile = Smoothstep((half_width + 0.5 * softness - across) / softness);
      At(x, y) += amplitude * static_cast<float>(ends * profile);
    }
  }
}

}  // namespace plslam::synthetic
