// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/world_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace plslam::synthetic {
namespace {

Eigen::Vector3d Unit(const Eigen::Vector3d& v) { return v / v.norm(); }

}  // namespace

double Lighting::At(const Eigen::Vector3d& p, const Eigen::Vector3d& n) const {
  double sum = ambient + std::max(0.0, n.dot(sun));
  for (const Lamp& lamp : lamps) {
    const Eigen::Vector3d to_lamp = lamp.position - p;
    const double distance2 = to_lamp.squaredNorm();
    const double facing = 0.6 + 0.4 * n.dot(to_lamp) / std::sqrt(distance2 + 1e-6);
    sum += lamp.strength * facing / (1.0 + distance2 / (lamp.reach_m * lamp.reach_m));
  }
  return sum;
}

Eigen::Vector3d Face::Normal() const { return Unit(down.cross(right)); }

Face Face::Part(double x, double y, double width, double height, double out) const {
  const Eigen::Vector3d unit_right = Unit(right);
  const Eigen::Vector3d unit_down = Unit(down);
  return {origin + x * unit_right + y * unit_down + out * Normal(), width * unit_right, height * unit_down};
}

WorldBuilder::WorldBuilder(Lighting lighting, std::vector<Eigen::Vector3d> path, double clearance_m)
    : lighting_(std::move(lighting)), path_(std::move(path)), clearance_m_(clearance_m) {}

void WorldBuilder::AddFace(const Face& face, const Material& material, double piece_m, bool is_landmark) {
  const Texture& texture = world_.textures()[material.texture];
  const double length_s = face.right.norm();
  const double length_t = face.down.norm();
  const int columns = std::max(1, static_cast<int>(std::ceil(length_s / piece_m)));
  const int rows = std::max(1, static_cast<int>(std::ceil(length_t / piece_m)));
  const bool fitted = material.texels_per_m == 0.0;
  const double texels_s = fitted ? texture.width() : length_s * material.texels_per_m;
  const double texels_t = fitted ? texture.height() : length_t * material.texels_per_m;
  const Eigen::Vector3d normal = face.Normal();
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      Quad quad;
      quad.edge_s = face.right / columns;
      quad.edge_t = face.down / rows;
      quad.origin = face.origin + column * quad.edge_s + row * quad.edge_t;
      quad.texture = material.texture;
      quad.texels_s = texels_s / columns;
      quad.texels_t = texels_t / rows;
      quad.u0 = column * quad.texels_s;
      quad.v0 = row * quad.texels_t;
      for (int corner = 0; corner < 4; ++corner) {
        const Eigen::Vector3d p = quad.origin + (corner % 2) * quad.edge_s + (corner / 2) * quad.edge_t;
        quad.light[corner] = static_cast<float>(lighting_.At(p, normal));
      }
      world_.AddQuad(quad);
    }
  }
  if (is_landmark) {
    const std::array<Eigen::Vector3d, 4> corners = {face.origin, face.origin + face.right,
                                                    face.origin + face.right + face.down, face.origin + face.down};
    for (int i = 0; i < 4; ++i) {
      world_.AddPoint(corners[i]);
      world_.AddSegment({corners[i], corners[(i + 1) % 4]});
    }
  }
}

bool WorldBuilder::IsClear(const Eigen::Vector3d& o, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                           const Eigen::Vector3d& c) const {
  return std::all_of(path_.begin(), path_.end(), [&](const Eigen::Vector3d& p) {
    Eigen::Vector3d outside = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& edge : {a, b, c}) {
      const double length = edge.norm();
      const Eigen::Vector3d unit = edge / length;
      const double along = unit.dot(p - o);
      outside += (along - std::clamp(along, 0.0, length)) * unit;
    }
    return outside.squaredNorm() >= clearance_m_ * clearance_m_;
  });
}

bool WorldBuilder::AddParallelepiped(const Eigen::Vector3d& o, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                     const Eigen::Vector3d& c, const Material& front, const Material& back,
                                     const Material& top, const Material& sides) {
  if (!IsClear(o, a, b, c)) {
    return false;
  }
  AddFace({o + c, a, -c}, front, 1e9, false);
  AddFace({o + a + c, b, -c}, sides, 1e9, false);
  AddFace({o + a + b + c, -a, -c}, back, 1e9, false);
  AddFace({o + b + c, -b, -c}, sides, 1e9, false);
  AddFace({o + b + c, a, -b}, top, 1e9, false);
  AddFace({o, a, b}, top, 1e9, false);
  for (int i = 0; i < 4; ++i) {
    const int half = i / 2;
    const double x = i % 2;
    const double y = half;
    AddSegment(o + x * a + y * b, o + x * a + y * b + c);
    AddSegment(o + x * a + y * c, o + x * a + y * c + b);
    AddSegment(o + x * b + y * c, o + x * b + y * c + a);
    world_.AddPoint(o + x * a + y * b);
    world_.AddPoint(o + x * a + y * b + c);
  }
  return true;
}

bool WorldBuilder::AddSlab(const Face& face, double depth_m, const Material& front, const Material& sides) {
  return AddParallelepiped(face.origin + face.down, face.right, -depth_m * face.Normal(), -face.down, front, sides,
                           sides, sides);
}

bool WorldBuilder::AddBox(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, double angle,
                          const Material& sides, const Material& top) {
  const Eigen::Vector3d a = size.x() * Eigen::Vector3d(Cos(angle), Sin(angle), 0.0);
  const Eigen::Vector3d b = size.y() * Eigen::Vector3d(-Sin(angle), Cos(angle), 0.0);
  const Eigen::Vector3d c(0.0, 0.0, size.z());
  return AddParallelepiped(centre - 0.5 * a - 0.5 * b, a, b, c, sides, sides, top, sides);
}

bool WorldBuilder::AddBeam(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double thickness_m,
                           const Material& sides, const Material& other_sides) {
  const Eigen::Vector3d along = b - a;
  const Eigen::Vector3d direction = Unit(along);
  const Eigen::Vector3d helper = std::abs(direction.z()) > 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d side = thickness_m * Unit(direction.cross(helper));
  const Eigen::Vector3d third = thickness_m * Unit(side.cross(direction));
  return AddParallelepiped(a - 0.5 * side - 0.5 * third, third, side, along, sides, sides, sides, other_sides);
}

}  // namespace plslam::synthetic
