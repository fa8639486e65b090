// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/datasets/synthetic/texture.h"
#include "core/geometry/se3.h"
#include "core/geometry/triangulation.h"

namespace plslam::synthetic {

/// A textured parallelogram: the points origin + s * edge_s + t * edge_t with s and t in [0, 1], seen from both
/// sides.
struct Quad {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d edge_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d edge_t = Eigen::Vector3d::Zero();
  int texture = 0;
  /// Texels at the origin, and per unit of s and t.
  double u0 = 0.0;
  double v0 = 0.0;
  double texels_s = 0.0;
  double texels_t = 0.0;
  /// Light at (s, t) = (0,0), (1,0), (0,1), (1,1); bilinear between.
  std::array<float, 4> light = {1.0F, 1.0F, 1.0F, 1.0F};
};

/// The geometry of a synthetic world in its frame w (metres), with the ground truth that tests compare with.
class World {
 public:
  const std::vector<Quad>& quads() const { return quads_; }
  const std::vector<Texture>& textures() const { return textures_; }
  /// True corners of posters, boxes, frames and doors. Their visibility in a picture follows from `Depth`.
  const std::vector<Eigen::Vector3d>& points() const { return points_; }
  /// True edges: borders of quads that differ in light or texture from the background, and painted lines.
  const std::vector<Segment3>& segments() const { return segments_; }
  /// Returns the grey value outside all quads, by the share of `up` in the squared viewing direction.
  float Sky(double up_share) const { return static_cast<float>(232.0 - 50.0 * up_share); }
  const Eigen::Vector3d& up() const { return up_; }

  /// Distance along the viewing direction `ray_w` (any length, in units of that length) to the first surface; nullopt
  /// for the sky. Tries every quad: exact and slow.
  std::optional<double> CastRay(const Eigen::Vector3d& origin_w, const Eigen::Vector3d& ray_w) const;

  /// The same world in another frame: `T_a_w` takes its points to frame a.
  void Move(const SE3& T_a_w);

  int AddTexture(Texture texture);
  void AddQuad(const Quad& quad) { quads_.push_back(quad); }
  void AddPoint(const Eigen::Vector3d& point) { points_.push_back(point); }
  void AddSegment(const Segment3& segment) { segments_.push_back(segment); }

 private:
  std::vector<Quad> quads_;
  std::vector<Texture> textures_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<Segment3> segments_;
  Eigen::Vector3d up_ = Eigen::Vector3d::UnitZ();
};

}  // namespace plslam::synthetic
