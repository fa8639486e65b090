// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/accuracy/consistency.h"
#include "core/map/map.h"
#include "core/run/recorder.h"
#include "viewer_headless/report/report_data.h"

namespace plslam::viewer {

/// Frames in a report at most; of longer runs every 2nd, 4th, 8th, ... frame of the recording is there.
inline constexpr size_t kMaxReportFrames = 20'000;

/// Every so many-th frame (of `frames().begin()`, counted one by one) a report of this run has.
int64_t FrameStride(const Recorder& recorder);

/// Returns the values that were published with each frame, from row `first_row` on (a row is a frame of the stride):
/// `id`, `t_s` since the first frame, `session` (0, 1, ... in order of appearance), `state`, `keyframe` (1: became
/// one), counts, `entropy_ratio`, `live` position in w as published, `odom` position by odometry alone (in the w of the
/// first frame of the session), and `stages_ms`, as wide as `stage_names`.
Table FrameTable(const Recorder& recorder, int64_t stride, int64_t first_row);

/// The path of the frames in the current map.
struct PathOfRun {
  /// `p` and `q` (x, y, z, w) of T_w_c in the final map; if there is truth, `truth` (position of the true camera,
  /// aligned with the path by a rigid motion), `error_m`, `error_deg` (after the mean rotation of the orientations),
  /// `live_error_m`; NaN if a frame has none.
  Table table;
  std::optional<double> ate_m;
  std::optional<double> live_ate_m;
  /// Sigma of the rotation about the path, of the alignment of the positions.
  std::optional<double> roll_sigma_deg;
  double length_m = 0.0;
  /// Root mean square of the distances of the true positions that have an estimated one from their mean.
  double true_spread_m = 0.0;
  /// Whether covariances of poses fit their errors; no samples without truth.
  Consistency consistency;
};
PathOfRun PathTable(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c, int64_t stride);

}  // namespace plslam::viewer
