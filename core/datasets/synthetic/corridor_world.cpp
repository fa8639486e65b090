// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "core/datasets/synthetic/materials.h"
#include "core/datasets/synthetic/world_builder.h"
#include "core/datasets/synthetic/worlds.h"

namespace plslam::synthetic {
namespace {

constexpr double kHalfX = 10.0;  // of the path down the middle of the corridors
constexpr double kHalfY = 6.0;
constexpr double kHalfWidth = 1.2;
constexpr double kHeight = 2.6;

class CorridorBuilder {
 public:
  explicit CorridorBuilder(const WorldRequest& request)
      : from_file_(request.from_file),
        seed_(request.seed),
        outer_(HallFor(request.path, request.from_file,
                       {2.0 * (kHalfX + kHalfWidth), 2.0 * (kHalfY + kHalfWidth), kHeight}, {2.5, 2.5, 1.3})),
        builder_(CorridorLight(), request.path, 0.6) {
    wall_ = builder_.Tiled(PaintPlaster(seed_ + 1, 175.0F, 5.0F), 128.0);
    frame_ = builder_.Tiled(PaintPlain(seed_ + 2, 95.0F, 3.0F), 64.0);
    lamp_ = builder_.Tiled(PaintPlain(seed_ + 3, 225.0F, 1.0F), 64.0);
    door_ = builder_.Fitted(PaintDoor(seed_ + 4, 140.0F));
  }

  World Build() {
    builder_.AddFace(outer_.Floor(), builder_.Tiled(PaintTiles(seed_ + 5, 150.0F), 256.0), 2.0);
    builder_.AddFace(outer_.Ceiling(), builder_.Tiled(PaintPlaster(seed_ + 6, 195.0F, 4.0F), 128.0), 2.0);
    for (const Face& face : outer_.Walls()) {
      AddWall(face);
    }
    if (!from_file_) {
      for (const Face& face : InnerWalls()) {
        AddWall(face);
      }
      AddLamps();
      AddSigns();
    }
    return builder_.Take();
  }

 private:
  static Lighting CorridorLight() {
    Lighting light;
    light.ambient = 0.92;
    light.sun = {0.05, 0.11, -0.08};  // sides differ a little, as under a row of lamps
    return light;
  }

  static std::array<Face, 4> InnerWalls() {
    const double x = kHalfX - kHalfWidth;
    const double y = kHalfY - kHalfWidth;
    const Eigen::Vector3d down(0.0, 0.0, -kHeight);
    return {Face{{-x, -y, kHeight}, {2.0 * x, 0.0, 0.0}, down}, Face{{x, -y, kHeight}, {0.0, 2.0 * y, 0.0}, down},
            Face{{x, y, kHeight}, {-2.0 * x, 0.0, 0.0}, down}, Face{{-x, y, kHeight}, {0.0, -2.0 * y, 0.0}, down}};
  }

  /// A wall with a door every 2.8 m, all alike, and a skirting board.
  void AddWall(const Face& wall) {
    builder_.AddFace(wall, wall_, 2.0);
    const double length = wall.right.norm();
    const double height = wall.down.norm();
    builder_.AddSlab(wall.Part(0.0, height - 0.09, length, 0.09, 0.015), 0.015, frame_, frame_);
    constexpr double kPitch = 2.8;
    const int doors = static_cast<int>(length / kPitch);
    const double first = 0.5 * (length - (doors - 1) * kPitch);
    for (int i = 0; i < doors; ++i) {
      const double x = first + i * kPitch - 0.45;
      const double top = height - 2.05;
      builder_.AddFace(wall.Part(x, top, 0.9, 2.05, 0.005), door_);
      builder_.AddSlab(wall.Part(x - 0.07, top - 0.07, 0.07, 2.12, 0.04), 0.04, frame_, frame_);
      builder_.AddSlab(wall.Part(x + 0.9, top - 0.07, 0.07, 2.12, 0.04), 0.04, frame_, frame_);
      builder_.AddSlab(wall.Part(x, top - 0.07, 0.9, 0.07, 0.04), 0.04, frame_, frame_);
    }
  }

  void AddLamps() {
    const auto lamp = [this](double x, double y, double size_x, double size_y) {
      const double z = kHeight - 0.03;
      builder_.AddFace({{x - 0.5 * size_x, y - 0.5 * size_y, z}, {size_x, 0.0, 0.0}, {0.0, size_y, 0.0}}, lamp_);
    };
    for (const double side : {-1.0, 1.0}) {
      for (double x = -kHalfX; x <= kHalfX; x += 2.5) {
        lamp(x, side * kHalfY, 1.2, 0.3);
      }
      for (double y = -kHalfY + 2.4; y <= kHalfY - 2.3; y += 2.4) {
        lamp(side * kHalfX, y, 0.3, 1.2);
      }
    }
  }

  /// One notice board at the end of each corridor, all different: the only distinction between the corridors.
  void AddSigns() {
    const std::array<Face, 4> walls = outer_.Walls();
    for (int i = 0; i < 4; ++i) {
      const Material poster = builder_.Fitted(PaintPoster(seed_ * 17 + 40 + i));
      const double x = walls[i].right.norm() - 0.95;
      builder_.AddSlab(walls[i].Part(x, 0.75, 0.6, 0.6, 0.02), 0.02, poster, frame_);
    }
  }

  bool from_file_;
  uint64_t seed_;
  Hall outer_;
  WorldBuilder builder_;
  Material wall_, frame_, lamp_, door_;
};

}  // namespace

Walk CorridorWalk() {
  Walk walk;
  walk.control_points = RoundedRectangle(kHalfX, kHalfY, 1.3, 0.6);
  walk.height_m = 1.45;
  walk.speed = 0.8;
  walk.sway = 0.8;
  walk.turn = 0.8;
  return walk;
}

World BuildCorridor(const WorldRequest& request) { return CorridorBuilder(request).Build(); }

}  // namespace plslam::synthetic
