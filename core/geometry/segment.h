// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace plslam {

/// A 3D line segment by its endpoints.
struct Segment3 {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d q = Eigen::Vector3d::Zero();
};

/// A line segment in an image, in pixels. Directed: the brighter side is on its right (as seen in the image).
struct Segment2 {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  Eigen::Vector2d q = Eigen::Vector2d::Zero();

  double Length() const { return (q - p).norm(); }
};

/// Infinite line through a segment: [a, b, c] with a*u + b*v + c = 0 and a^2 + b^2 = 1, so that products with
/// homogeneous points are distances in pixels. The segment must have positive length.
Eigen::Vector3d LineThrough(const Segment2& segment);

}  // namespace plslam
