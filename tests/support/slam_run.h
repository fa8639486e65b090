// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "mapping_process/mapper.h"
#include "tests/support/odometry_run.h"

namespace plslam::test {

/// Result of tracking and mapping over a dataset.
struct SlamRun {
  /// As published at the time: T_odom_l holds T_w_l(estimated).
  std::vector<OdometryFrame> live;
  /// Frames moved with the final poses of the keyframes.
  std::vector<OdometryFrame> final;
  int keyframes = 0;
  /// Moving bodies that were published.
  int n_bodies = 0;
  size_t points = 0;
  size_t lines = 0;
  double observations_per_point = 0.0;
  double observations_per_line = 0.0;
  /// Per keyframe, ms, and the figures of its adjustment.
  std::vector<double> insert_ms;
  std::vector<double> adjust_ms;
  std::vector<AdjustmentFigures> figures;
  Map map;
  StereoCamera camera;
  /// Features of the keyframes of `map`.
  KeyframeFeatures features;
};

/// The frames of a run, given in odom, where the map's keyframes carry them.
std::vector<OdometryFrame> CarriedByKeyframes(std::vector<OdometryFrame> in_odom, const Map& map);

/// Front end, odometry and mapping over a dataset in this process, as in lockstep: the map of a keyframe takes effect
/// when the next keyframe has been made.
SlamRun RunSlam(const Dataset& dataset, const vo::VoOptions& vo, const mapping::MappingOptions& mapping,
                int stride = 1, int max_frames = 1 << 30);

}  // namespace plslam::test
