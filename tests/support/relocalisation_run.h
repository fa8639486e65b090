// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/datasets/dataset.h"
#include "loop_process/loop_closer.h"
#include "mapping_process/options.h"
#include "vo_process/options.h"

namespace plslam::test {

/// One time that the lens was covered while the camera was carried elsewhere in the map.
struct RelocalisationTrial {
  int from_frame = 0;  ///< last frame before, and the first after
  int to_frame = 0;
  double carried_m = 0.0;
  /// Frames with observation until the pose in the map was right for the first time, and after that wrong ones; -1:
  /// never right.
  int frames_until_right = -1;
  int wrong_afterwards = 0;
  int asked = 0;
  int answered = 0;
  int answered_wrongly = 0;
  /// A pose was given out as tracked that was wrong.
  int wrong_before = 0;
};

struct RelocalisationTrials {
  int covered_frames = 40;
  int seen_frames = 20;
  double min_carried_m = 5.0;
  /// Error limits of a correct relocalisation, against the truth aligned with the map at the nearest keyframe.
  double max_error_m = 0.1;
  double max_error_deg = 1.0;
};

/// Makes a map of the dataset, and then, from its end, runs trials drawn by `seed`: no features for a while, then the
/// frames from elsewhere on. The requests to loop_process are those of vo_process. In this process, as in lockstep.
std::vector<RelocalisationTrial> RunRelocalisationTrials(const Dataset& dataset, const PlaceRecogniser& places,
                                                         const vo::VoOptions& vo,
                                                         const mapping::MappingOptions& mapping,
                                                         const loop::LoopOptions& loops,
                                                         const RelocalisationTrials& trials, int n_trials,
                                                         uint64_t seed);

}  // namespace plslam::test
