// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/worlds.h"

#include <algorithm>

namespace plslam::synthetic {

Face Hall::Floor() const { return {{low.x(), high.y(), low.z()}, {size().x(), 0.0, 0.0}, {0.0, -size().y(), 0.0}}; }

Face Hall::Ceiling() const { return {{low.x(), low.y(), high.z()}, {size().x(), 0.0, 0.0}, {0.0, size().y(), 0.0}}; }

std::array<Face, 4> Hall::Walls() const {
  const Eigen::Vector3d down(0.0, 0.0, -size().z());
  return {Face{{high.x(), low.y(), high.z()}, {-size().x(), 0.0, 0.0}, down},
          Face{{high.x(), high.y(), high.z()}, {0.0, -size().y(), 0.0}, down},
          Face{{low.x(), high.y(), high.z()}, {size().x(), 0.0, 0.0}, down},
          Face{{low.x(), low.y(), high.z()}, {0.0, size().y(), 0.0}, down}};
}

Hall HallFor(const std::vector<Eigen::Vector3d>& path, bool from_file, const Eigen::Vector3d& size,
             const Eigen::Vector3d& margin_m) {
  Hall hall{{-0.5 * size.x(), -0.5 * size.y(), 0.0}, {0.5 * size.x(), 0.5 * size.y(), size.z()}};
  if (!from_file) {
    return hall;
  }
  Eigen::Vector3d low = path.front();
  Eigen::Vector3d high = path.front();
  for (const Eigen::Vector3d& p : path) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3d centre = 0.5 * (low + high);
  const Eigen::Vector3d half = (0.5 * (high - low) + margin_m).cwiseMax(0.5 * size);
  return {centre - half, centre + half};
}

const std::vector<WorldKind>& WorldKinds() {
  static const std::vector<WorldKind> kinds = {
      {"room", 0.11, 80.0, RoomWalk, BuildRoom},
      {"corridor", 0.11, 80.0, CorridorWalk, BuildCorridor},
      {"street", 0.50, 80.0, StreetWalk, BuildStreet},
      {"whitewall", 0.11, 80.0, WhitewallWalk, BuildWhitewall},
  };
  return kinds;
}

const WorldKind& FindWorldKind(const std::string& name) {
  return *std::find_if(WorldKinds().begin(), WorldKinds().end(),
                       [&name](const WorldKind& kind) { return kind.name == name; });
}

}  // namespace plslam::synthetic
