// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "loop_process/loop_closer.h"
#include "tests/unit/mapping/loop_world.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::test {

/// Returns vocabularies made of the landmarks of a world.
PlaceRecogniser PlacesOf(const FeatureWorld& world);

/// A ring of landmarks and a walk around it that ends a little after its beginning; the tracker gives no ids, so only
/// loop closing can detect that both ends are one place.
struct Ring {
  FeatureWorld world;
  Walk walk;

  explicit Ring(int keyframes = 70, uint64_t seed = 1);
  int size() const { return static_cast<int>(walk.keyframes.size()); }
};

/// A mapper and a loop closer that have been shown the first `n` keyframes, as in lockstep, every loop taken over.
struct Closing {
  mapping::Mapper mapper;
  loop::LoopCloser closer;
  std::vector<LoopClosure> loops;

  Closing(const PlaceRecogniser& places, const loop::LoopOptions& options);
  /// The answer to this keyframe, before the map has taken it over.
  LoopClosure Show(const Keyframe& keyframe);
  void TakeOver(const LoopClosure& loop);
};

Closing CloseLoops(const Ring& ring, const loop::LoopOptions& options = {});

}  // namespace plslam::test
