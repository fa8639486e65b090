// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/renderer.h"

#include <algorithm>
#include <array>

namespace plslam::synthetic {
namespace {

constexpr int kSamples = 32;
using Samples = std::array<float, kSamples>;

/// Columns are in order; rows are the bit-reversed order (a Hammersley set), so that both are evenly spread.
struct Pattern {
  Samples dx;
  Samples dy;
};

constexpr Pattern MakePattern() {
  Pattern pattern{};
  for (int i = 0; i < kSamples; ++i) {
    int reversed = 0;
    for (int bit = 0; bit < 5; ++bit) {
      reversed |= ((i >> bit) & 1) << (4 - bit);
    }
    pattern.dx[i] = (static_cast<float>(i) + 0.5F) / kSamples - 0.5F;
    pattern.dy[i] = (static_cast<float>(reversed) + 0.5F) / kSamples - 0.5F;
  }
  return pattern;
}

constexpr Pattern kPattern = MakePattern();

/// Data for shading a surface: light is bilinear in texel coordinates.
struct Surface {
  const ScreenQuad* screen = nullptr;
  const Texture* texture = nullptr;
  float light = 0.0F;
  float light_u = 0.0F;
  float light_v = 0.0F;
  float light_uv = 0.0F;
};

Surface MakeSurface(const Scene& scene, const ScreenQuad& screen) {
  const Quad& quad = scene.quad(screen.quad);
  // Bilinear in s = (u - u0) / texels_s and t likewise, multiplied out.
  const double per_u = 1.0 / quad.texels_s;
  const double per_v = 1.0 / quad.texels_t;
  const double ds = quad.light[1] - quad.light[0];
  const double dt = quad.light[2] - quad.light[0];
  const double dst = quad.light[3] - quad.light[1] - dt;
  Surface surface{&screen, &scene.world->textures()[quad.texture]};
  surface.light = static_cast<float>(quad.light[0] - quad.u0 * per_u * ds - quad.v0 * per_v * dt +
                                     quad.u0 * quad.v0 * per_u * per_v * dst);
  surface.light_u = static_cast<float>(per_u * (ds - quad.v0 * per_v * dst));
  surface.light_v = static_cast<float>(per_v * (dt - quad.u0 * per_u * dst));
  surface.light_uv = static_cast<float>(per_u * per_v * dst);
  return surface;
}

float Shade(const Surface& surface, double x, double y) {
  const ScreenQuad& screen = *surface.screen;
  const double z = 1.0 / screen.inverse_depth.At(x, y);
  const double u = screen.u.At(x, y) * z;
  const double v = screen.v.At(x, y) * z;
  const Footprint footprint = {static_cast<float>((screen.u.a - u * screen.inverse_depth.a) * z),
                               static_cast<float>((screen.v.a - v * screen.inverse_depth.a) * z),
                               static_cast<float>((screen.u.b - u * screen.inverse_depth.b) * z),
                               static_cast<float>((screen.v.b - v * screen.inverse_depth.b) * z)};
  const auto uf = static_cast<float>(u);
  const auto vf = static_cast<float>(v);
  const float light = surface.light + surface.light_u * uf + (surface.light_v + surface.light_uv * uf) * vf;
  return light * surface.texture->Sample(uf, vf, footprint);
}

class Renderer {
 public:
  Renderer(const Scene& scene, const View& view)
      : world_(*scene.world),
        view_(view),
        quads_(ProjectQuads(scene, view)),
        visible_(FindVisible(quads_, view.width, view.height)) {
    surfaces_.reserve(quads_.size());
    for (const ScreenQuad& quad : quads_) {
      surfaces_.push_back(MakeSurface(scene, quad));
    }
  }

  std::vector<float> Radiance() const {
    std::vector<float> out(static_cast<size_t>(view_.width) * view_.height);
    for (int y = 0, pixel = 0; y < view_.height; ++y) {
      for (int x = 0; x < view_.width; ++x, ++pixel) {
        out[pixel] = visible_.first_fragment[pixel] < 0 ? ShadeAt(visible_.surface[pixel], x, y) : Split(pixel, x, y);
      }
    }
    return out;
  }

  std::vector<float> Depth() const {
    std::vector<float> out(static_cast<size_t>(view_.width) * view_.height);
    for (int y = 0, pixel = 0; y < view_.height; ++y) {
      for (int x = 0; x < view_.width; ++x, ++pixel) {
        const ScreenQuad* quad = NearestAt(pixel, x, y);
        out[pixel] = quad != nullptr ? static_cast<float>(1.0 / quad->inverse_depth.At(x, y)) : 0.0F;
      }
    }
    return out;
  }

  std::vector<int> Quads() const {
    std::vector<int> out(static_cast<size_t>(view_.width) * view_.height);
    for (int y = 0, pixel = 0; y < view_.height; ++y) {
      for (int x = 0; x < view_.width; ++x, ++pixel) {
        const ScreenQuad* quad = NearestAt(pixel, x, y);
        out[pixel] = quad != nullptr ? quad->quad : -1;
      }
    }
    return out;
  }

 private:
  float ShadeAt(int surface, double x, double y) const {
    if (surface >= 0) {
      return Shade(surfaces_[surface], x, y);
    }
    const double rx = (x - view_.cx) / view_.fx;
    const double ry = (y - view_.cy) / view_.fy;
    const Eigen::Vector3d& up = world_.up();
    double along = 0.0;
    for (int i = 0; i < 3; ++i) {
      along += up[i] * (view_.R_w_c(i, 0) * rx + view_.R_w_c(i, 1) * ry + view_.R_w_c(i, 2));
    }
    return world_.Sky(along * along / (rx * rx + ry * ry + 1.0));
  }

  /// At the centre of the pixel; nullptr for the sky.
  const ScreenQuad* NearestAt(int pixel, int x, int y) const {
    const ScreenQuad* nearest = visible_.surface[pixel] >= 0 ? &quads_[visible_.surface[pixel]] : nullptr;
    for (int f = visible_.first_fragment[pixel]; f >= 0; f = visible_.fragments[f].next) {
      const ScreenQuad& quad = quads_[visible_.fragments[f].surface];
      const bool inside = std::all_of(quad.border.begin(), quad.border.end(),
                                      [x, y](const Linear& border) { return border.At(x, y) >= 0.0; });
      if (inside && quad.inverse_depth.At(x, y) > (nearest != nullptr ? nearest->inverse_depth.At(x, y) : 0.0)) {
        nearest = &quad;
      }
    }
    return nearest;
  }

  /// The nearest surface of each sample so far.
  struct Winners {
    Samples inverse_depth = {};
    std::array<int, kSamples> surface;
  };

  void Enter(int surface, double x, double y, bool whole, Winners& winners) const {
    const ScreenQuad& quad = quads_[surface];
    Samples least;  // distance inside, over the borders that cross the pixel
    least.fill(1.0F);
    for (int i = 0; i < 4 && !whole; ++i) {
      const Linear& border = quad.border[i];
      const double centre = border.At(x, y);
      if (centre < quad.border_half[i]) {
        const Samples distance = AtSamples(border, centre);
        for (int k = 0; k < kSamples; ++k) {
          least[k] = std::min(least[k], distance[k]);
        }
      }
    }
    const Samples depth = AtSamples(quad.inverse_depth, quad.inverse_depth.At(x, y));
    for (int k = 0; k < kSamples; ++k) {
      const float here = least[k] >= 0.0F ? depth[k] : 0.0F;
      const float so_far = winners.inverse_depth[k];
      const int winner = winners.surface[k];
      winners.inverse_depth[k] = std::max(here, so_far);
      winners.surface[k] = here > so_far ? surface : winner;
    }
  }

  static Samples AtSamples(const Linear& function, double centre) {
    const auto c = static_cast<float>(centre);
    const auto a = static_cast<float>(function.a);
    const auto b = static_cast<float>(function.b);
    Samples values;
    for (int k = 0; k < kSamples; ++k) {
      values[k] = c + a * kPattern.dx[k] + b * kPattern.dy[k];
    }
    return values;
  }

  float Split(int pixel, int x, int y) const {
    Winners winners;
    winners.surface.fill(-1);
    if (visible_.surface[pixel] >= 0) {
      Enter(visible_.surface[pixel], x, y, true, winners);
    }
    for (int f = visible_.first_fragment[pixel]; f >= 0; f = visible_.fragments[f].next) {
      Enter(visible_.fragments[f].surface, x, y, false, winners);
    }
    return Blend(winners, x, y);
  }

  /// Mean over the samples, each surface shaded once at the centroid of its own samples.
  float Blend(const Winners& winners, int x, int y) const {
    std::array<bool, kSamples> done = {};
    float sum = 0.0F;
    for (int k = 0; k < kSamples; ++k) {
      if (done[k]) {
        continue;
      }
      const int surface = winners.surface[k];
      float dx = 0.0F;
      float dy = 0.0F;
      int count = 0;
      for (int m = k; m < kSamples; ++m) {
        if (winners.surface[m] == surface) {
          done[m] = true;
          dx += kPattern.dx[m];
          dy += kPattern.dy[m];
          ++count;
        }
      }
      const auto n = static_cast<float>(count);
      sum += n * ShadeAt(surface, x + static_cast<double>(dx / n), y + static_cast<double>(dy / n));
    }
    return sum / kSamples;
  }

  const World& world_;
  const View& view_;
  std::vector<ScreenQuad> quads_;
  Visibility visible_;
  std::vector<Surface> surfaces_;
};

}  // namespace

std::vector<float> RenderRadiance(const Scene& scene, const View& view) { return Renderer(scene, view).Radiance(); }

std::vector<float> RenderRollingShutter(const Scene& scene, const std::function<View(double)>& view_at) {
  // With 480 rows, a camera that turns by 20 pixels during readout moves by a sixth of a pixel from band to band.
  constexpr int kBandRows = 4;
  const View whole = view_at(0.0);
  std::vector<float> radiance;
  radiance.reserve(static_cast<size_t>(whole.width) * whole.height);
  for (int row = 0; row < whole.height; row += kBandRows) {
    const int rows = std::min(kBandRows, whole.height - row);
    View band = view_at((row + 0.5 * (rows - 1)) / whole.height);
    band.height = rows;
    band.cy -= row;
    const std::vector<float> part = RenderRadiance(scene, band);
    radiance.insert(radiance.end(), part.begin(), part.end());
  }
  return radiance;
}

std::vector<float> RenderDepthMap(const Scene& scene, const View& view) { return Renderer(scene, view).Depth(); }

std::vector<int> RenderQuadMap(const Scene& scene, const View& view) { return Renderer(scene, view).Quads(); }

}  // namespace plslam::synthetic
