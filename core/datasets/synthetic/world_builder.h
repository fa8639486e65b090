// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/datasets/synthetic/exact_math.h"
#include "core/datasets/synthetic/world.h"

namespace plslam::synthetic {

/// A texture on a surface: repeated with so many texels a metre, or stretched over the surface once (0).
struct Material {
  int texture = 0;
  double texels_per_m = 0.0;
};

/// Light of a world: everywhere, from one direction, and from lamps that fade with distance.
struct Lighting {
  struct Lamp {
    Eigen::Vector3d position;
    double strength = 0.0;
    double reach_m = 1.0;
  };
  double ambient = 1.0;
  Eigen::Vector3d sun = Eigen::Vector3d::Zero();  ///< towards it, length is its strength
  std::vector<Lamp> lamps;

  /// Light on a surface at `p` with the unit normal `n`.
  double At(const Eigen::Vector3d& p, const Eigen::Vector3d& n) const;
};

/// A rectangle seen from its front: `origin` is the top left corner, `right` and `down` its sides in metres.
struct Face {
  Eigen::Vector3d origin;
  Eigen::Vector3d right;
  Eigen::Vector3d down;

  /// Unit normal, towards the viewer.
  Eigen::Vector3d Normal() const;
  /// A rectangle on this face: `x` and `y` metres from its top left corner, standing `out` metres off it.
  Face Part(double x, double y, double width, double height, double out) const;
};

/// Puts faces, slabs and boxes into a world, lit, with their corners and edges as ground truth.
class WorldBuilder {
 public:
  /// `path` are positions of the camera; solid things keep `clearance_m` from them.
  WorldBuilder(Lighting lighting, std::vector<Eigen::Vector3d> path, double clearance_m);

  Material Tiled(const Texture& texture, double texels_per_m) { return {world_.AddTexture(texture), texels_per_m}; }
  Material Fitted(const Texture& texture) { return {world_.AddTexture(texture), 0.0}; }

  /// One face, cut into pieces of at most `piece_m` so that light changes over it; its border becomes segments.
  void AddFace(const Face& face, const Material& material, double piece_m = 1e9, bool is_landmark = true);
  /// Adds a face with sides of `depth` metres: a poster, a board, a cupboard on a wall. Returns false if too near the
  /// path.
  bool AddSlab(const Face& face, double depth_m, const Material& front, const Material& sides);
  /// An upright box standing on `centre` (middle of its bottom), turned by `angle`. Returns false if too near the path.
  bool AddBox(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, double angle, const Material& sides,
              const Material& top);
  /// A beam from a to b of square section. Returns false if too near the path.
  bool AddBeam(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double thickness_m, const Material& sides) {
    return AddBeam(a, b, thickness_m, sides, sides);
  }
  /// The same with one pair of opposite sides of another material.
  bool AddBeam(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double thickness_m, const Material& sides,
               const Material& other_sides);

  void AddSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& q) { world_.AddSegment({p, q}); }
  World Take() { return std::move(world_); }

 private:
  /// The box of corner `o` and edges a, b, c (right-handed, c upwards): its six faces, edges and corners.
  bool AddParallelepiped(const Eigen::Vector3d& o, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                         const Eigen::Vector3d& c, const Material& front, const Material& back, const Material& top,
                         const Material& sides);
  bool IsClear(const Eigen::Vector3d& o, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
               const Eigen::Vector3d& c) const;

  World world_;
  Lighting lighting_;
  std::vector<Eigen::Vector3d> path_;
  double clearance_m_;
};

}  // namespace plslam::synthetic
