// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/world.h"

#include <cmath>
#include <utility>

namespace plslam::synthetic {
namespace {

/// Returns the distance along the ray at which it meets the quad, in units of the ray; nullopt if it does not.
std::optional<double> Meet(const Quad& quad, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d normal = quad.edge_s.cross(quad.edge_t);
  const double along = normal.dot(ray);
  if (std::abs(along) < 1e-12 * normal.norm()) {
    return std::nullopt;
  }
  const double distance = normal.dot(quad.origin - origin) / along;
  const Eigen::Vector3d q = origin + distance * ray - quad.origin;
  const double norm2 = normal.squaredNorm();
  const double s = q.cross(quad.edge_t).dot(normal) / norm2;
  const double t = quad.edge_s.cross(q).dot(normal) / norm2;
  const bool hit = distance > 1e-6 && s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0;
  return hit ? std::optional<double>(distance) : std::nullopt;
}

}  // namespace

std::optional<double> World::CastRay(const Eigen::Vector3d& origin_w, const Eigen::Vector3d& ray_w) const {
  std::optional<double> nearest;
  for (const Quad& quad : quads_) {
    const std::optional<double> distance = Meet(quad, origin_w, ray_w);
    if (distance && (!nearest || *distance < *nearest)) {
      nearest = distance;
    }
  }
  return nearest;
}

void World::Move(const SE3& T_a_w) {
  const Eigen::Matrix3d R = T_a_w.R();
  for (Quad& quad : quads_) {
    quad.origin = R * quad.origin + T_a_w.translation();
    quad.edge_s = R * quad.edge_s;
    quad.edge_t = R * quad.edge_t;
  }
  for (Eigen::Vector3d& point : points_) {
    point = R * point + T_a_w.translation();
  }
  for (Segment3& segment : segments_) {
    segment.p = R * segment.p + T_a_w.translation();
    segment.q = R * segment.q + T_a_w.translation();
  }
  up_ = R * up_;
}

int World::AddTexture(Texture texture) {
  textures_.push_back(std::move(texture));
  return static_cast<int>(textures_.size()) - 1;
}

}  // namespace plslam::synthetic
