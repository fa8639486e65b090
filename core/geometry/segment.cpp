// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/segment.h"

namespace plslam {

Eigen::Vector3d LineThrough(const Segment2& segment) {
  const Eigen::Vector2d direction = (segment.q - segment.p).normalized();
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  // Anchored at the middle: the offset is largest, so loses the fewest digits, far from the origin.
  const Eigen::Vector2d middle = 0.5 * (segment.p + segment.q);
  return {normal.x(), normal.y(), -normal.dot(middle)};
}

}  // namespace plslam
