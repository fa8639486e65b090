// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "core/datasets/synthetic/materials.h"
#include "core/datasets/synthetic/world_builder.h"
#include "core/datasets/synthetic/worlds.h"

namespace plslam::synthetic {
namespace {

constexpr double kEyeHeight = 1.65;
constexpr double kLane = 4.6;  // from the path to the kerb

/// A position beside the path.
struct Station {
  Eigen::Vector3d position;
  Eigen::Vector3d forward;  // level, unit
  Eigen::Vector3d Left() const { return {-forward.y(), forward.x(), 0.0}; }
};

/// An upright box on the ground: centre and half sides along two level axes.
struct Footprint2 {
  Eigen::Vector2d centre;
  Eigen::Vector2d along;  // unit
  double half_along = 0.0;
  double half_across = 0.0;

  /// Separating axis test with a gap.
  bool Meets(const Footprint2& other) const {
    const auto reach = [](const Footprint2& f, const Eigen::Vector2d& axis) {
      const Eigen::Vector2d across(-f.along.y(), f.along.x());
      return f.half_along * std::abs(axis.dot(f.along)) + f.half_across * std::abs(axis.dot(across));
    };
    for (const Eigen::Vector2d& along_axis : {along, other.along}) {
      for (const Eigen::Vector2d& axis : {along_axis, Eigen::Vector2d(-along_axis.y(), along_axis.x())}) {
        if (std::abs(axis.dot(other.centre - centre)) > reach(*this, axis) + reach(other, axis) + 0.3) {
          return false;
        }
      }
    }
    return true;
  }
};

class StreetBuilder {
 public:
  explicit StreetBuilder(const WorldRequest& request)
      : random_(Hash(request.seed, 0x737472656574ULL)),
        seed_(request.seed),
        path_(request.path),
        builder_(Daylight(), request.path, 1.2) {
    ground_ = path_.front().z();
    for (const Eigen::Vector3d& p : path_) {
      ground_ = std::min(ground_, p.z());
    }
    ground_ -= kEyeHeight;
    for (int i = 0; i < 10; ++i) {
      facades_.push_back(builder_.Fitted(PaintFacade(seed_ * 37 + 10 + i, 4 + i % 4, 2 + i % 3)));
      cars_.push_back(builder_.Fitted(PaintCar(seed_ * 37 + 50 + i)));
    }
    roof_ = builder_.Tiled(PaintPlain(seed_ + 1, 90.0F, 8.0F), 32.0);
    pole_ = builder_.Tiled(PaintPlain(seed_ + 2, 70.0F, 4.0F), 64.0);
    stone_ = builder_.Tiled(PaintTiles(seed_ + 3, 165.0F), 256.0);
    paint_ = builder_.Tiled(PaintPlaster(seed_ + 4, 215.0F, 14.0F), 256.0);
    asphalt_ = builder_.Tiled(PaintAsphalt(seed_ + 5), 128.0);
  }

  World Build() {
    AddGround();
    for (const double side : {-1.0, 1.0}) {
      Along(10.0, [&](const Station& station, int) { AddKerb(station, side); });
      Along(2.0, [&](const Station& station, int) { AddHouse(station, side); });
      Along(24.0, [&](const Station& station, int) { AddPole(station, side); });
      Along(7.5, [&](const Station& station, int) { AddCar(station, side); });
    }
    Along(6.0, [&](const Station& station, int) { AddMark(station); });
    return builder_.Take();
  }

 private:
  static Lighting Daylight() {
    Lighting light;
    light.ambient = 0.62;
    light.sun = {0.20, 0.27, 0.22};
    return light;
  }

  /// Calls `place` every `pitch_m` along the path, wherever it moves.
  template <typename Place>
  void Along(double pitch_m, const Place& place) {
    double left = 0.5 * pitch_m;
    int number = 0;
    for (size_t i = 0; i + 1 < path_.size(); ++i) {
      Eigen::Vector3d step = path_[i + 1] - path_[i];
      step.z() = 0.0;
      const double length = step.norm();
      while (length > 1e-9 && left <= length) {
        place(Station{path_[i] + step * (left / length), step / length}, number++);
        left += pitch_m;
      }
      left -= length;
    }
  }

  Eigen::Vector3d Beside(const Station& station, double lateral, double height) const {
    Eigen::Vector3d p = station.position + lateral * station.Left();
    p.z() = ground_ + height;
    return p;
  }

  /// Returns true, and reserves the footprint, if it does not overlap existing ones and keeps `distance` from the path.
  bool Claim(const Footprint2& footprint, double distance) {
    const Eigen::Vector2d across(-footprint.along.y(), footprint.along.x());
    for (const Eigen::Vector3d& p : path_) {
      const Eigen::Vector2d q = p.head<2>() - footprint.centre;
      const double x = std::max(0.0, std::abs(q.dot(footprint.along)) - footprint.half_along);
      const double y = std::max(0.0, std::abs(q.dot(across)) - footprint.half_across);
      if (x * x + y * y < distance * distance) {
        return false;
      }
    }
    if (std::any_of(taken_.begin(), taken_.end(), [&](const Footprint2& f) { return f.Meets(footprint); })) {
      return false;
    }
    taken_.push_back(footprint);
    return true;
  }

  /// An upright block turned with the path; four sides and a top.
  void AddBlock(const Station& station, const Eigen::Vector3d& bottom, const Eigen::Vector3d& size,
                const Material& side, const Material& end, const Material& top) {
    const Eigen::Vector3d a = size.x() * station.forward;
    const Eigen::Vector3d b = size.y() * station.Left();
    const Eigen::Vector3d up(0.0, 0.0, size.z());
    const Eigen::Vector3d o = bottom - 0.5 * a - 0.5 * b + up;
    builder_.AddFace({o, a, -up}, side);
    builder_.AddFace({o + a, b, -up}, end);
    builder_.AddFace({o + a + b, -a, -up}, side);
    builder_.AddFace({o + b, -b, -up}, end);
    builder_.AddFace({o + b, a, -b}, top);
  }

  void AddGround() {
    Eigen::Vector3d low = path_.front();
    Eigen::Vector3d high = low;
    for (const Eigen::Vector3d& p : path_) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const Eigen::Vector3d size = high - low + Eigen::Vector3d(160.0, 160.0, 0.0);
    const Eigen::Vector3d origin(low.x() - 80.0, high.y() + 80.0, ground_);
    builder_.AddFace({origin, {size.x(), 0.0, 0.0}, {0.0, -size.y(), 0.0}}, asphalt_, 40.0, false);
  }

  void AddKerb(const Station& station, double side) {
    const Footprint2 area{Beside(station, side * (kLane + 1.1), 0.0).head<2>(), station.forward.head<2>(), 4.9, 1.1};
    if (Claim(area, kLane - 0.8)) {
      const Eigen::Vector3d at = Beside(station, side * (kLane + 1.1), 0.0);
      AddBlock(station, at, {9.8, 2.2, 0.13}, stone_, stone_, stone_);
    }
  }

  void AddHouse(const Station& station, double side) {
    const double length = random_.Uniform(11.0, 19.0);
    const double depth = random_.Uniform(7.0, 10.0);
    const double setback = random_.Uniform(7.2, 8.2);
    const double height = random_.Uniform(6.0, 11.0) + std::max(0.0, station.position.z() - ground_ - kEyeHeight);
    const Eigen::Vector3d at = Beside(station, side * (setback + 0.5 * depth), 0.0);
    if (!Claim({at.head<2>(), station.forward.head<2>(), 0.5 * length, 0.5 * depth}, 6.5)) {
      return;
    }
    const Material& front = facades_[random_.Int(static_cast<int>(facades_.size()))];
    AddBlock(station, at, {length, depth, height}, front, front, roof_);
    // The eaves protrude; a true edge in space against the sky.
    AddBlock(station, at + Eigen::Vector3d(0.0, 0.0, height), {length + 0.5, depth + 0.5, 0.25}, roof_, roof_, roof_);
  }

  void AddPole(const Station& station, double side) {
    const Eigen::Vector3d at = Beside(station, side * (kLane + 0.5), 0.13);
    const Footprint2 area{at.head<2>(), station.forward.head<2>(), 0.08, 0.08};
    for (const Eigen::Vector3d& p : path_) {
      if ((p.head<2>() - area.centre).norm() < 2.0) {
        return;
      }
    }
    AddBlock(station, at, {0.14, 0.14, 5.2}, pole_, pole_, pole_);
    const Eigen::Vector3d arm = Beside(station, side * (kLane - 0.2), 5.33);
    AddBlock(station, arm, {0.25, 1.7, 0.12}, pole_, pole_, pole_);
  }

  void AddCar(const Station& station, double side) {
    const double length = random_.Uniform(3.6, 4.6);
    const Eigen::Vector3d at = Beside(station, side * (kLane - 1.15), 0.0);
    if (random_.Chance(0.45) || !Claim({at.head<2>(), station.forward.head<2>(), 0.5 * length, 0.9}, 2.2)) {
      return;
    }
    const Material& side_paint = cars_[random_.Int(static_cast<int>(cars_.size()))];
    AddBlock(station, at, {length, 1.75, random_.Uniform(1.3, 1.7)}, side_paint, side_paint, roof_);
  }

  void AddMark(const Station& station) {
    const Eigen::Vector3d along = 3.0 * station.forward;
    const Eigen::Vector3d across = -0.15 * station.Left();
    builder_.AddFace({Beside(station, 0.0, 0.012) - 0.5 * along - 0.5 * across, along, across}, paint_);
  }

  Random random_;
  uint64_t seed_;
  std::vector<Eigen::Vector3d> path_;
  double ground_ = 0.0;
  WorldBuilder builder_;
  std::vector<Footprint2> taken_;
  std::vector<Material> facades_, cars_;
  Material roof_, pole_, stone_, paint_, asphalt_;
};

}  // namespace

Walk StreetWalk() {
  Walk walk;
  walk.control_points = ScaledToLength(RoundedRectangle(48.0, 36.0, 12.0, 6.0), 320.0);
  walk.height_m = kEyeHeight;
  walk.speed = 6.0;
  walk.sway = 1.0;
  walk.turn = 0.5;
  return walk;
}

World BuildStreet(const WorldRequest& request) { return StreetBuilder(request).Build(); }

}  // namespace plslam::synthetic
