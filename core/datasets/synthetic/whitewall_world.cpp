// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <bit>

#include "core/datasets/synthetic/canvas.h"
#include "core/datasets/synthetic/world_builder.h"
#include "core/datasets/synthetic/worlds.h"

namespace plslam::synthetic {
namespace {

constexpr float kWhite = 172.0F;
constexpr float kFloorTint = -26.0F;
constexpr float kCeilingTint = 18.0F;
constexpr double kFade =
    0.22;  // share of a line's length over which it fades at each end, so that it has no end point

/// A white face on which soft stripes are painted. In its four corners it has the same grey as every other face, so
/// that the edges between faces fade there too.
class WhiteFace {
 public:
  WhiteFace(const Face& face, uint64_t seed, float tint)
      : face_(face),
        width_m_(face.right.norm()),
        height_m_(face.down.norm()),
        scale_(std::min(256.0, 2048.0 / std::max(width_m_, height_m_))),
        canvas_(Side(width_m_ * scale_), Side(height_m_ * scale_), kWhite),
        random_(seed) {
    Shade(tint);
  }

  Random& random() { return random_; }
  double width_m() const { return width_m_; }
  double height_m() const { return height_m_; }

  /// A stripe between two points of the face, metres from its top left corner.
  void Stripe(std::array<double, 2> a, std::array<double, 2> b, double half_width_m, double contrast) {
    const double softness = std::max(2.5, 0.010 * scale_);
    canvas_.SoftStripe({a[0] * scale_, a[1] * scale_}, {b[0] * scale_, b[1] * scale_}, half_width_m * scale_,
                       softness, kFade, static_cast<float>(contrast));
    const double dx = b[0] - a[0];
    const double dy = b[1] - a[1];
    const double length = std::sqrt(dx * dx + dy * dy);
    for (const double side : {-half_width_m, half_width_m}) {
      const double nx = -dy / length * side;
      const double ny = dx / length * side;
      edges_.push_back(
          {On(a[0] + kFade * dx + nx, a[1] + kFade * dy + ny), On(b[0] - kFade * dx + nx, b[1] - kFade * dy + ny)});
    }
  }

  void AddTo(WorldBuilder& builder) const {
    builder.AddFace(face_, builder.Tiled(canvas_.ToTexture(Texture::Border::kClamp), scale_), 1e9, false);
    for (const Segment3& edge : edges_) {
      builder.AddSegment(edge.p, edge.q);
    }
  }

 private:
  static int Side(double texels) { return static_cast<int>(std::bit_ceil(static_cast<unsigned>(texels))); }

  Eigen::Vector3d On(double x, double y) const {
    return face_.origin + x / width_m_ * face_.right + y / height_m_ * face_.down;
  }

  void Shade(float tint) {
    for (int y = 0; y < canvas_.height(); ++y) {
      const double from_y = std::min((y + 0.5) / scale_, height_m_ - (y + 0.5) / scale_);
      for (int x = 0; x < canvas_.width(); ++x) {
        const double from_x = std::min((x + 0.5) / scale_, width_m_ - (x + 0.5) / scale_);
        const double reach = std::sqrt(from_x * from_x + from_y * from_y) / 1.1;
        canvas_.At(x, y) += tint * static_cast<float>(Smoothstep(reach));
      }
    }
  }

  Face face_;
  double width_m_;
  double height_m_;
  double scale_;
  Canvas canvas_;
  Random random_;
  std::vector<Segment3> edges_;
};

double Contrast(Random& random) {
  return random.Chance(0.6) ? -random.Uniform(30.0, 42.0) : random.Uniform(26.0, 36.0);
}

/// Verticals and slanted stripes side by side, none of which crosses another; a rail below the ceiling and one above
/// the floor.
void PaintWall(WhiteFace& wall) {
  Random& random = wall.random();
  const double height = wall.height_m();
  int kind = random.Int(3);
  for (double x = 0.45; x + 0.5 < wall.width_m(); x += random.Uniform(0.45, 0.65), ++kind) {
    const double low = height - random.Uniform(0.15, 0.4);
    const double high = random.Uniform(0.15, 0.4);
    const double lean = kind % 3 == 2 ? random.Uniform(0.3, 0.5) : 0.0;
    if (kind % 3 == 2) {
      x += 0.1;
    }
    const double contrast = Contrast(random);
    wall.Stripe({x, low}, {x + lean, high}, random.Uniform(0.03, 0.07), contrast);
    x += lean;
  }
  wall.Stripe({0.3, 0.07}, {wall.width_m() - 0.3, 0.07}, 0.03, -30.0);
  wall.Stripe({0.3, height - 0.07}, {wall.width_m() - 0.3, height - 0.07}, 0.03, -32.0);
}

/// Slanted stripes side by side: roof beams, or joints of a floor covering.
void PaintSlanted(WhiteFace& face, double slant, double pitch) {
  Random& random = face.random();
  for (double x = 0.4; x + std::max(0.0, slant) + 0.4 < face.width_m(); x += pitch) {
    const double start = x + std::max(0.0, -slant);
    if (start + slant > 0.3 && start < face.width_m() - 0.3) {
      const double contrast = Contrast(random);
      face.Stripe({start, 0.3}, {start + slant, face.height_m() - 0.3}, random.Uniform(0.03, 0.08), contrast);
    }
  }
}

/// Greys of a bar at its top and bottom, where it meets ceiling and floor, and in between.
struct BarGreys {
  float top = 0.0F;
  float middle = 0.0F;
  float bottom = 0.0F;
};

/// A bar that fades into the adjacent surfaces.
Material FadingBar(WorldBuilder& builder, const BarGreys& greys) {
  Canvas canvas(8, 256, greys.middle);
  for (int y = 0; y < canvas.height(); ++y) {
    const double along = (y + 0.5) / canvas.height();
    const auto to_top = static_cast<float>(1.0 - Smoothstep(along / kFade));
    const auto to_bottom = static_cast<float>(1.0 - Smoothstep((1.0 - along) / kFade));
    const float grey = greys.middle + to_top * (greys.top - greys.middle) + to_bottom * (greys.bottom - greys.middle);
    for (int x = 0; x < canvas.width(); ++x) {
      canvas.At(x, y) = grey;
    }
  }
  return builder.Fitted(canvas.ToTexture(Texture::Border::kClamp));
}

/// Real bars off the walls: slanted rails and columns along all walls, struts across the corners.
void AddBars(const Hall& hall, WorldBuilder& builder) {
  const float top = kWhite + kCeilingTint;
  const float bottom = kWhite + kFloorTint;
  const Material dark = FadingBar(builder, {top, kWhite - 38.0F, bottom});
  const Material light = FadingBar(builder, {top, kWhite - 22.0F, bottom});
  const Material strut = FadingBar(builder, {kWhite, kWhite - 38.0F, kWhite});
  const Material strut_light = FadingBar(builder, {kWhite, kWhite - 22.0F, kWhite});
  for (const Face& wall : hall.Walls()) {
    const double length = wall.right.norm();
    const double height = wall.down.norm();
    const Eigen::Vector3d right = wall.right / length;
    const Eigen::Vector3d down = wall.down / height;
    const auto at = [&](double x, double y, double out) -> Eigen::Vector3d {
      return wall.origin + x * right + y * down + out * wall.Normal();
    };
    builder.AddBeam(at(0.10 * length, height, 0.30), at(0.42 * length, 0.0, 0.30), 0.06, dark, light);
    builder.AddBeam(at(0.90 * length, height, 0.22), at(0.62 * length, 0.0, 0.22), 0.06, dark, light);
    builder.AddBeam(at(0.52 * length, height, 0.35), at(0.52 * length, 0.0, 0.35), 0.09, light, dark);
    builder.AddBeam(at(0.0, 0.35, 0.9), at(0.12 * length, 0.0, 0.0), 0.07, strut, strut_light);
  }
}

}  // namespace

Walk WhitewallWalk() {
  Walk walk = RoomWalk();
  walk.control_points = ScaledToLength(RoundedRectangle(2.45, 1.55, 1.45, 0.7), 13.5);
  walk.speed = 0.9;
  return walk;
}

World BuildWhitewall(const WorldRequest& request) {
  const Hall hall = HallFor(request.path, request.from_file, {8.0, 6.0, 3.0}, {2.5, 2.5, 1.5});
  WorldBuilder builder(Lighting{}, request.path, 0.55);
  const uint64_t seed = Hash(request.seed, 0x7768697465ULL);
  constexpr std::array<float, 4> kTints = {8.0F, -12.0F, 10.0F, -8.0F};
  const std::array<Face, 4> walls = hall.Walls();
  for (int i = 0; i < 4; ++i) {
    WhiteFace wall(walls[i], seed + i, kTints[i]);
    PaintWall(wall);
    wall.AddTo(builder);
  }
  WhiteFace floor(hall.Floor(), seed + 4, kFloorTint);
  PaintSlanted(floor, 1.6, 0.75);
  floor.AddTo(builder);
  WhiteFace ceiling(hall.Ceiling(), seed + 5, kCeilingTint);
  PaintSlanted(ceiling, -2.2, 0.8);
  ceiling.AddTo(builder);
  AddBars(hall, builder);
  return builder.Take();
}

}  // namespace plslam::synthetic
