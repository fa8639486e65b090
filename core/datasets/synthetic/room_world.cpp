// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "core/datasets/synthetic/materials.h"
#include "core/datasets/synthetic/world_builder.h"
#include "core/datasets/synthetic/worlds.h"

namespace plslam::synthetic {
namespace {

class RoomBuilder {
 public:
  explicit RoomBuilder(const WorldRequest& request)
      : random_(Hash(request.seed, 0x726f6f6dULL)),
        changes_(Hash(request.seed, 0x6368616eULL)),
        is_changed_(request.is_changed),
        seed_(request.seed),
        hall_(HallFor(request.path, request.from_file, {8.0, 6.0, 3.0}, {2.5, 2.5, 1.5})),
        builder_(RoomLight(hall_), request.path, 0.6) {
    white_ = builder_.Tiled(PaintPlain(seed_ + 1, 205.0F, 4.0F), 64.0);
    wood_ = builder_.Tiled(PaintPlanks(seed_ + 2, 120.0F), 400.0);
    dark_ = builder_.Tiled(PaintPlain(seed_ + 3, 60.0F, 6.0F), 64.0);
    door_ = builder_.Fitted(PaintDoor(seed_ + 4, 150.0F));
    outside_ = builder_.Fitted(PaintPoster(seed_ + 5));
    for (int i = 0; i < 6; ++i) {
      posters_.usual.push_back(builder_.Fitted(PaintPoster(seed_ * 31 + 100 + i)));
      books_.usual.push_back(builder_.Fitted(PaintBooks(seed_ * 31 + 200 + i)));
      boxes_.usual.push_back(builder_.Fitted(PaintBox(seed_ * 31 + 300 + i)));
    }
    if (!is_changed_) return;
    for (int i = 0; i < 6; ++i) {
      posters_.other.push_back(builder_.Fitted(PaintPoster(seed_ * 31 + 400 + i)));
      books_.other.push_back(builder_.Fitted(PaintBooks(seed_ * 31 + 500 + i)));
      boxes_.other.push_back(builder_.Fitted(PaintBox(seed_ * 31 + 600 + i)));
    }
  }

  World Build() {
    AddShell();
    const std::array<Face, 4> walls = hall_.Walls();
    for (int i = 0; i < 4; ++i) {
      Furnish(walls[i], i);
    }
    AddMiddle();
    return builder_.Take();
  }

 private:
  static Lighting RoomLight(const Hall& hall) {
    Lighting light;
    light.ambient = 0.55;
    const double z = hall.high.z() - 0.5;
    const double y = 0.5 * (hall.low.y() + hall.high.y());
    for (const double share : {0.25, 0.75}) {
      light.lamps.push_back({{hall.low.x() + share * hall.size().x(), y + 0.4, z}, 0.55, 3.0});
    }
    return light;
  }

  /// Materials of things of one kind, and of those that replace some of them.
  struct Materials {
    std::vector<Material> usual, other;
  };

  const Material& Any(const Materials& materials) {
    const int i = random_.Int(static_cast<int>(materials.usual.size()));
    return (IsReplaced() ? materials.other : materials.usual)[i];
  }

  /// Draws whether the next thing is replaced, or moved. Everything else is that of the unchanged room.
  bool IsReplaced() {
    constexpr double kShare = 0.3;
    return is_changed_ && changes_.Uniform(0.0, 1.0) < kShare;
  }
  /// Returns how far the next thing is moved along its wall.
  double Moved() { return IsReplaced() ? changes_.Uniform(0.05, 0.15) : 0.0; }

  void AddShell() {
    builder_.AddFace(hall_.Floor(), builder_.Tiled(PaintPlanks(seed_ + 6, 135.0F), 384.0), 1.5);
    builder_.AddFace(hall_.Ceiling(), builder_.Tiled(PaintPlaster(seed_ + 7, 200.0F, 9.0F), 256.0), 1.5);
    const std::array<Material, 3> papers = {builder_.Tiled(PaintWallpaper(seed_ + 8, 175.0F, 22.0F), 320.0),
                                            builder_.Tiled(PaintBricks(seed_ + 9, 135.0F), 512.0),
                                            builder_.Tiled(PaintPlaster(seed_ + 10, 185.0F, 14.0F), 256.0)};
    const std::array<Face, 4> walls = hall_.Walls();
    const double height = hall_.size().z();
    for (int i = 0; i < 4; ++i) {
      builder_.AddFace(walls[i], papers[i % 3], 1.5);
      const double length = walls[i].right.norm();
      builder_.AddSlab(walls[i].Part(0.0, height - 0.10, length, 0.10, 0.02), 0.02, white_, white_);
    }
    for (double x = hall_.low.x() + 1.3; x < hall_.high.x() - 0.5; x += 1.8) {  // beams under the ceiling
      builder_.AddBeam({x, hall_.low.y(), hall_.high.z() - 0.09}, {x, hall_.high.y(), hall_.high.z() - 0.09}, 0.18,
                       wood_);
    }
  }

  /// Fills a wall from left to right with one thing after the other, each kind in turn from a different start.
  void Furnish(const Face& wall, int number) {
    const double length = wall.right.norm();
    const double height = hall_.size().z();
    int kind = number;
    double x = random_.Uniform(0.25, 0.5);
    while (x + 1.3 < length) {
      const double width = random_.Uniform(0.95, 1.3);
      switch (kind % 5) {
        case 0:
          AddPictures(wall, x, width);
          break;
        case 1:
          AddShelf(wall, x, height, width);
          break;
        case 2:
          AddWindow(wall, x, width);
          break;
        case 3:
          AddCrates(wall, x, height, width);
          break;
        default:
          AddDoor(wall, x, height);
          break;
      }
      x += width + random_.Uniform(0.15, 0.4);
      ++kind;
    }
  }

  void AddPictures(const Face& wall, double x, double width) {
    const double size = random_.Uniform(0.7, 0.95) * width;
    const double y = random_.Uniform(0.7, 1.0);
    builder_.AddSlab(wall.Part(x, y, size, size, 0.03), 0.03, Any(posters_), dark_);
    builder_.AddSlab(wall.Part(x + 0.05, y + size + 0.15, 0.45 * size, 0.35, 0.02), 0.02, Any(boxes_), white_);
    builder_.AddSlab(wall.Part(x + 0.55 * size, y + size + 0.12, 0.4 * size, 0.42, 0.02), 0.02, Any(posters_),
                     white_);
  }

  void AddShelf(const Face& wall, double x, double height, double width) {
    const double top = 0.75;
    constexpr double kDepth = 0.30;
    const double rise = height - top - 0.1;
    for (const double side : {0.0, width - 0.03}) {
      builder_.AddSlab(wall.Part(x + side, top, 0.03, rise, kDepth), kDepth, wood_, wood_);
    }
    const int boards = std::max(3, static_cast<int>(rise / 0.42));
    for (int i = 0; i <= boards; ++i) {
      const double y = top + rise * i / boards;
      builder_.AddSlab(wall.Part(x + 0.03, y, width - 0.06, 0.025, kDepth), kDepth, wood_, wood_);
      if (i < boards) {
        const double room = rise / boards - 0.03;
        builder_.AddSlab(wall.Part(x + 0.03, y + 0.03, width - 0.06, room, kDepth - 0.08), kDepth - 0.09, Any(books_),
                         dark_);
      }
    }
  }

  void AddWindow(const Face& wall, double x, double width) {
    const double y = 0.6;
    constexpr double kRise = 1.2;
    builder_.AddFace(wall.Part(x + 0.05, y + 0.05, width - 0.1, kRise - 0.1, 0.01), outside_);
    for (const double bar : {0.0, 0.5 * width - 0.03, width - 0.06}) {
      builder_.AddSlab(wall.Part(x + bar, y, 0.06, kRise, 0.06), 0.06, white_, white_);
    }
    for (const double bar : {0.0, 0.42 * kRise, kRise - 0.06}) {
      builder_.AddSlab(wall.Part(x, y + bar, width, 0.06, 0.055), 0.055, white_, white_);
    }
    builder_.AddSlab(wall.Part(x - 0.05, y + kRise, width + 0.1, 0.04, 0.2), 0.2, white_, white_);
    builder_.AddSlab(wall.Part(x, y + kRise + 0.25, width, 0.6, 0.1), 0.1, white_, white_);  // radiator
    for (double rib = 0.06; rib + 0.05 < width; rib += 0.1) {
      builder_.AddSlab(wall.Part(x + rib, y + kRise + 0.27, 0.05, 0.56, 0.13), 0.03, white_, white_);
    }
  }

  void AddCrates(const Face& wall, double x, double height, double width) {
    double top = height;
    x += Moved();
    for (int layer = 0; layer < 3; ++layer) {
      const double rise = random_.Uniform(0.3, 0.5);
      const double wide = width * random_.Uniform(0.55, 0.95);
      const double deep = random_.Uniform(0.3, 0.5);
      top -= rise;
      const Material& sides = Any(boxes_);
      const Material& front = Any(boxes_);
      const double left = x + random_.Uniform(0.0, width - wide);
      builder_.AddSlab(wall.Part(left, top, wide, rise, deep), deep - 0.001, front, sides);
    }
    builder_.AddSlab(wall.Part(x + 0.1, 0.45, 0.7, 0.55, 0.02), 0.02, Any(posters_), dark_);
  }

  void AddDoor(const Face& wall, double x, double height) {
    const double top = height - 2.1;
    builder_.AddSlab(wall.Part(x + 0.08, top, 0.9, 2.1, 0.01), 0.01, door_, wood_);
    builder_.AddSlab(wall.Part(x, top - 0.08, 0.08, 2.18, 0.04), 0.04, white_, white_);
    builder_.AddSlab(wall.Part(x + 0.98, top - 0.08, 0.08, 2.18, 0.04), 0.04, white_, white_);
    builder_.AddSlab(wall.Part(x + 0.08, top - 0.08, 0.9, 0.08, 0.04), 0.04, white_, white_);
    builder_.AddSlab(wall.Part(x + 0.25, top + 0.45, 0.4, 0.5, 0.02), 0.01, Any(posters_), white_);
  }

  /// A table with things on it, and crates about it.
  void AddMiddle() {
    const Eigen::Vector3d centre(0.5 * (hall_.low.x() + hall_.high.x()), 0.5 * (hall_.low.y() + hall_.high.y()),
                                 hall_.low.z());
    if (builder_.AddBox(centre + Eigen::Vector3d(0.0, 0.0, 0.70), {1.8, 0.8, 0.05}, 0.2, wood_, wood_)) {
      for (int leg = 0; leg < 4; ++leg) {
        const double x = leg % 2 == 0 ? -0.75 : 0.75;
        const double y = leg / 2 == 0 ? -0.3 : 0.3;
        builder_.AddBox(centre + Eigen::Vector3d(Cos(0.2) * x - Sin(0.2) * y, Sin(0.2) * x + Cos(0.2) * y, 0.0),
                        {0.06, 0.06, 0.70}, 0.2, dark_, dark_);
      }
      for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d at = centre + Eigen::Vector3d(-0.55 + 0.55 * i, random_.Uniform(-0.12, 0.12), 0.75);
        const Material& lid = Any(boxes_);
        const Material& sides = Any(boxes_);
        const double angle = random_.Uniform(0.0, 1.5) + 4.0 * Moved();
        builder_.AddBox(at, {0.3, 0.22, random_.Uniform(0.2, 0.45)}, angle, sides, lid);
      }
    }
    builder_.AddFace({{centre.x() - 1.3, centre.y() + 0.8, centre.z() + 0.01}, {2.6, 0.0, 0.0}, {0.0, -1.6, 0.0}},
                     posters_.usual[0]);  // a rug
  }

  Random random_;
  Random changes_;
  bool is_changed_;
  uint64_t seed_;
  Hall hall_;
  WorldBuilder builder_;
  Material white_, wood_, dark_, door_, outside_;
  Materials posters_, books_, boxes_;
};

}  // namespace

Walk RoomWalk() {
  Walk walk;
  walk.control_points = ScaledToLength(RoundedRectangle(2.7, 1.75, 1.6, 0.8), 15.0);
  walk.height_m = 1.5;
  walk.speed = 1.0;
  walk.yaw_offset = 0.1;
  return walk;
}

World BuildRoom(const WorldRequest& request) { return RoomBuilder(request).Build(); }

}  // namespace plslam::synthetic
