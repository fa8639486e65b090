// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/io/maps/map_file.h"
#include "tools/refine/batch_problem.h"
#include "tools/refine/pair_choice.h"

namespace plslam::refine {

struct RefineProgress {
  /// From 1.
  int pass = 0;
  int iteration = 0;
  double cost = 0.0;
  /// Until the end of the work, as the iterations so far suggest (`RemainingTime`).
  double remaining_s = 0.0;
};

struct RefineOptions {
  CameraChoice camera = CameraChoice::kFixed;
  int threads = 1;
  uint64_t memory_bytes = uint64_t{2} << 30;
  /// Receives one sentence before the first solve: expected time and memory.
  std::function<void(const std::string&)> announce;
  /// Called after each iteration.
  std::function<void(const RefineProgress&)> progress;
  /// Ends the work with the best map so far.
  const std::atomic<bool>* stop = nullptr;
};

/// One column of the table: the state of a map, over the observations that fit there.
struct MapFit {
  int64_t keyframes = 0;
  int64_t points = 0;
  int64_t lines = 0;
  int64_t point_observations = 0;
  int64_t line_observations = 0;
  /// Root mean squares: whitened, and in pixels of the left image.
  double normalised = 0.0;
  double point_px = 0.0;
  double line_px = 0.0;
  int64_t loops = 0;
  /// Root mean square of the distances between the positions that loops measured and those of the map.
  double loop_m = 0.0;
  /// Sum of the distances between consecutive keyframes of the sessions.
  double length_m = 0.0;
};

struct RefineReport {
  MapFit before;
  MapFit after;
  /// Half the robust cost of each pass, at its start and at its end. Passes differ in their observations.
  struct Pass {
    double cost_before = 0.0;
    double cost_after = 0.0;
    int iterations = 0;
    double seconds = 0.0;
    int64_t changed_observations = 0;
  };
  std::vector<Pass> passes;
  PairEstimate pair;
  BatchDemand demand;
  /// Parts of the map that nothing connects; each keeps its own first keyframe.
  int parts = 1;
  bool stopped = false;
  bool has_covariances = false;
};

/// Adjusts a whole map in batch: all keyframe poses, points, lines and, if asked for, the camera. Between passes,
/// observations that do not fit are dropped, those of the best covisible keyframes that fit where their landmark is now
/// expected are added, landmarks that are the same are fused, and points without inliers are triangulated again, until less than 0.5 % of the
/// observations change. The first keyframe of each part of the map keeps its pose.
///
/// If the camera changed, features are re-expressed in the ideal pair that the estimate stands for, so that the map
/// agrees with its new `camera`. If it is stopped before the parameters of the camera are chosen, map and camera are
/// unchanged. Throws std::runtime_error with one sentence if the map has no features or cannot be
/// solved; the map is then unchanged.
RefineReport RefineMap(StoredMap& stored, StereoCamera& camera, const RefineOptions& options);

}  // namespace plslam::refine
