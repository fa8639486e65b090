// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/worlds.h"

#include <algorithm>

namespace plslam::synthetic {

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
