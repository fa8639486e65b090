// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/rasterizer.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace plslam::synthetic {
namespace {

struct Triple {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

Triple Cross(const Triple& a, const Triple& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double Dot(const Triple& a, const Triple& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Triple Sum(const Triple& a, const Triple& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

Triple Rotated(const Eigen::Matrix3d& R_w_c, const Eigen::Vector3d& p) {
  return {R_w_c(0, 0) * p[0] + R_w_c(1, 0) * p[1] + R_w_c(2, 0) * p[2],
          R_w_c(0, 1) * p[0] + R_w_c(1, 1) * p[1] + R_w_c(2, 1) * p[2],
          R_w_c(0, 2) * p[0] + R_w_c(1, 2) * p[1] + R_w_c(2, 2) * p[2]};
}

/// The function n . ray(x, y) over pixels, with ray = ((x - cx)/fx, (y - cy)/fy, 1).
Linear OverPixels(const Triple& n, const View& view, double scale) {
  const double a = n.x / view.fx * scale;
  const double b = n.y / view.fy * scale;
  return {a, b, n.z * scale - a * view.cx - b * view.cy};
}

Linear Combined(const Linear& f, double k, const Linear& g, double m) {
  return {f.a * k + g.a * m, f.b * k + g.b * m, f.c * k + g.c * m};
}

/// Rows that the corners may touch; nullopt when all of them lie outside one side of the image.
std::optional<std::array<int, 2>> RowRange(const std::array<Triple, 4>& corners, const View& view) {
  constexpr double kNear = 0.05;
  const double left = (-1.0 - view.cx) / view.fx;
  const double right = (view.width - view.cx) / view.fx;
  const double top = (-1.0 - view.cy) / view.fy;
  const double bottom = (view.height - view.cy) / view.fy;
  std::array<int, 5> outside = {};
  double first = 1e9;
  double last = -1e9;
  bool all_in_front = true;
  for (const Triple& p : corners) {
    outside[0] += p.z < kNear ? 1 : 0;
    outside[1] += p.x < left * p.z ? 1 : 0;
    outside[2] += p.x > right * p.z ? 1 : 0;
    outside[3] += p.y < top * p.z ? 1 : 0;
    outside[4] += p.y > bottom * p.z ? 1 : 0;
    all_in_front = all_in_front && p.z > kNear;
    if (p.z > kNear) {
      const double row = p.y / p.z * view.fy + view.cy;
      first = std::min(first, row);
      last = std::max(last, row);
    }
  }
  if (*std::max_element(outside.begin(), outside.end()) == 4) {
    return std::nullopt;
  }
  if (!all_in_front) {
    return std::array<int, 2>{0, view.height - 1};
  }
  const double height = view.height;
  return std::array<int, 2>{static_cast<int>(std::clamp(first - 1.0, 0.0, height - 1.0)),
                            static_cast<int>(std::clamp(last + 2.0, 0.0, height - 1.0))};
}

void SetBorders(const Linear& s, const Linear& t, ScreenQuad& screen) {
  screen.border = {s, t, Combined(screen.inverse_depth, 1.0, s, -1.0), Combined(screen.inverse_depth, 1.0, t, -1.0)};
  for (int i = 0; i < 4; ++i) {
    Linear& border = screen.border[i];
    const double length = std::sqrt(border.a * border.a + border.b * border.b);
    const double scale = length > 1e-300 ? 1.0 / length : 1.0;
    border = {border.a * scale, border.b * scale, border.c * scale};
    screen.border_half[i] = 0.5 * (std::abs(border.a) + std::abs(border.b));
  }
}

std::optional<ScreenQuad> Project(const Quad& quad, int index, const View& view) {
  const Triple p = Rotated(view.R_w_c, quad.origin - view.t_w_c);
  const Triple e = Rotated(view.R_w_c, quad.edge_s);
  const Triple g = Rotated(view.R_w_c, quad.edge_t);
  const auto rows = RowRange({p, Sum(p, e), Sum(p, g), Sum(Sum(p, e), g)}, view);
  const Triple normal = Cross(e, g);
  const double determinant = Dot(normal, p);
  if (!rows || std::abs(determinant) < 1e-9 * std::sqrt(Dot(normal, normal))) {
    return std::nullopt;  // out of view, or seen exactly from its side
  }
  // The inverse of [e g p] takes a ray to (s, t, 1) / z.
  const Linear s = OverPixels(Cross(g, p), view, 1.0 / determinant);
  const Linear t = OverPixels(Cross(p, e), view, 1.0 / determinant);
  ScreenQuad screen;
  screen.quad = index;
  screen.first_row = (*rows)[0];
  screen.last_row = (*rows)[1];
  screen.inverse_depth = OverPixels(normal, view, 1.0 / determinant);
  screen.depth_half = 0.5 * (std::abs(screen.inverse_depth.a) + std::abs(screen.inverse_depth.b));
  screen.u = Combined(s, quad.texels_s, screen.inverse_depth, quad.u0);
  screen.v = Combined(t, quad.texels_t, screen.inverse_depth, quad.v0);
  SetBorders(s, t, screen);
  return screen;
}

/// Columns [first, last] of one row.
struct Columns {
  int first = 0;
  int last = -1;
};

/// Returns the columns whose centres have all border distances of at least `sign` times their half widths: +1 gives the
/// completely covered pixels, -1 all touched ones.
Columns Covered(const ScreenQuad& quad, int row, double sign, int width) {
  double first = 0.0;
  double last = width - 1.0;
  for (int i = 0; i < 4; ++i) {
    const Linear& border = quad.border[i];
    const double rest = border.b * row + border.c - sign * quad.border_half[i];
    if (border.a > 1e-12) {
      first = std::max(first, std::ceil(std::min(-rest / border.a, 1e8)));
    } else if (border.a < -1e-12) {
      last = std::min(last, std::floor(std::max(-rest / border.a, -1e8)));
    } else if (rest < 0.0) {
      return {};
    }
  }
  return {static_cast<int>(first), static_cast<int>(last)};
}

void FillWhole(const ScreenQuad& quad, int index, int row, const Columns& columns, Visibility& out) {
  float* depth = out.inverse_depth.data() + static_cast<size_t>(row) * out.width;
  int* surface = out.surface.data() + static_cast<size_t>(row) * out.width;
  const auto start = static_cast<float>(quad.inverse_depth.b * row + quad.inverse_depth.c);
  const auto slope = static_cast<float>(quad.inverse_depth.a);
  for (int x = columns.first; x <= columns.last; ++x) {
    const float here = start + slope * static_cast<float>(x);
    const bool nearer = here > depth[x];
    depth[x] = nearer ? here : depth[x];
    surface[x] = nearer ? index : surface[x];
  }
}

void PushFragment(int pixel, int surface, Visibility& out) {
  out.fragments.push_back({surface, out.first_fragment[pixel]});
  out.first_fragment[pixel] = static_cast<int>(out.fragments.size()) - 1;
}

/// Keeps the partly covered pixels of a row, unless they are occluded by a quad that covers the complete pixel.
void PushPartial(const std::vector<ScreenQuad>& quads, int index, int row, int first, int last, Visibility& out) {
  const ScreenQuad& quad = quads[index];
  for (int x = first; x <= last; ++x) {
    const int pixel = row * out.width + x;
    const double nearest = quad.inverse_depth.At(x, row) + quad.depth_half;
    const int whole = out.surface[pixel];
    if (whole < 0 || nearest > out.inverse_depth[pixel] - quads[whole].depth_half) {
      PushFragment(pixel, index, out);
    }
  }
}

/// Neighbouring pixels of different surfaces without a border between them: surfaces that cut each other, or a border
/// exactly between the pixels. Each gets the other as a fragment.
void PushCuts(Visibility& out) {
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x + 1 < out.width; ++x) {
      const int a = y * out.width + x;
      for (const int b : {a + 1, y + 1 < out.height ? a + out.width : a}) {
        const int surface_a = out.surface[a];
        const int surface_b = out.surface[b];
        const bool borderless = out.first_fragment[a] < 0 && out.first_fragment[b] < 0;
        if (surface_a != surface_b && surface_a >= 0 && surface_b >= 0 && borderless) {
          PushFragment(a, surface_b, out);
          PushFragment(b, surface_a, out);
        }
      }
    }
  }
}

}  // namespace

std::vector<ScreenQuad> ProjectQuads(const Scene& scene, const View& view) {
  std::vector<ScreenQuad> seen;
  for (int i = 0; i < scene.size(); ++i) {
    if (const auto screen = Project(scene.quad(i), i, view)) {
      seen.push_back(*screen);
    }
  }
  return seen;
}

Visibility FindVisible(const std::vector<ScreenQuad>& quads, int width, int height) {
  Visibility out;
  out.width = width;
  out.height = height;
  const size_t pixels = static_cast<size_t>(width) * height;
  out.surface.assign(pixels, -1);
  out.inverse_depth.assign(pixels, 0.0F);
  out.first_fragment.assign(pixels, -1);
  const int count = static_cast<int>(quads.size());
  for (int i = 0; i < count; ++i) {
    for (int row = quads[i].first_row; row <= quads[i].last_row; ++row) {
      FillWhole(quads[i], i, row, Covered(quads[i], row, 1.0, width), out);
    }
  }
  for (int i = 0; i < count; ++i) {
    for (int row = quads[i].first_row; row <= quads[i].last_row; ++row) {
      const Columns touched = Covered(quads[i], row, -1.0, width);
      const Columns whole = Covered(quads[i], row, 1.0, width);
      if (whole.first > whole.last) {
        PushPartial(quads, i, row, touched.first, touched.last, out);
      } else {
        PushPartial(quads, i, row, touched.first, whole.first - 1, out);
        PushPartial(quads, i, row, whole.last + 1, touched.last, out);
      }
    }
  }
  PushCuts(out);
  return out;
}

}  // namespace plslam::synthetic
