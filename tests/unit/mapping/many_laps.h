// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "mapping_process/mapper.h"
#include "tests/support/feature_world.h"

namespace plslam::test {

/// A world in which some landmarks are replaced after each lap, and a closed path through it.
class ChangingWorld {
 public:
  static constexpr int kKeyframes = 36;  // a lap

  ChangingWorld() : world_(Counts(), 1) {}

  static SE3 PoseAt(int i);
  const FeatureWorld& world() const { return world_; }

  /// Replaces a share of the landmarks by new ones.
  void Change(double share, uint64_t seed);

 private:
  static FeatureWorld::Counts Counts() { return {.points = 500, .lines = 60}; }

  FeatureWorld world_;
};

/// Laps of `ChangingWorld` without images: a front end that detects some of the features, and a tracker that names
/// those of the map by their descriptors, some of them wrongly.
struct LapsOptions {
  int laps = 20;
  mapping::MappingOptions mapping;
  uint64_t seed = 1;
  double noise_px = 0.4;
  double motion_sigma_m = 0.01;
  double motion_sigma_rad = 0.004;
  /// Share of the features that a keyframe detects.
  double detected = 0.7;
  /// Shares of the map's landmarks among them that the tracker does not name, and that it confuses with another.
  double unnamed = 0.2;
  double confused = 0.01;
  /// Share of the world that is replaced after each lap.
  double replaced = 0.0;
};

struct LapsResult {
  /// Root mean square of the positions of each lap's keyframes against the truth, after the first two laps were
  /// aligned: as estimated at the time, and in the final map.
  std::vector<double> live_m, final_m;
  /// Share of the map's points that are not in the world any more, after each lap.
  std::vector<double> gone;
  /// Largest numbers at any time.
  MapTotals most;
  Map map;
  FeatureWorld world;
};

LapsResult RunLaps(const LapsOptions& options);

}  // namespace plslam::test
