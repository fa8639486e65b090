// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/run/frame_tally.h"
#include "tools/plslam/id_counter.h"
#include "tools/plslam/stage_times.h"

namespace plslam {

/// What one frame's pose message tells of the run.
struct FrameReport {
  int64_t session = 0;
  int64_t frame_id = 0;
  int64_t t_ns = 0;
  TrackingState state = TrackingState::kInitialising;
  int64_t keyframe_id = -1;
  int tracked_points = 0;
  int tracked_lines = 0;
  int skipped_frames = 0;
  int features = 0;
  int moving = 0;  ///< features on moving bodies, and bodies of the session so far
  int bodies = 0;
  std::vector<std::pair<std::string, double>> stage_ms;
};

/// Counts a run, frame by frame, in memory that hardly grows with its length: by a bit for each landmark.
class RunStatistics {
 public:
  void AddFrame(const FrameReport& frame);
  void AddLandmark(int64_t session, int64_t landmark_id, bool is_line);

  /// Frames with a pose message, and those that these say were skipped; one that a restarted tracker does again
  /// counts once.
  const FrameTally& frames() const { return frames_; }
  const MovingTally& moving() const { return moving_; }
  int64_t keyframes() const { return keyframes_; }
  int64_t landmark_points() const { return points_.count(); }
  int64_t landmark_lines() const { return lines_.count(); }
  const FrameReport& last() const { return last_; }
  /// Number and time of the newest frame that has a pose; -1: none.
  std::pair<int64_t, int64_t> newest_frame() const { return {newest_frame_id_, newest_t_ns_}; }
  /// Session and number there of the newest keyframe; -1: none.
  std::pair<int64_t, int64_t> last_keyframe() const { return last_keyframe_; }
  const std::map<std::string, QuantileSketch>& stage_ms() const { return stage_ms_.by_name(); }

 private:
  FrameTally frames_;
  MovingTally moving_;
  int64_t keyframes_ = 0;
  int64_t newest_frame_id_ = -1;
  int64_t newest_t_ns_ = 0;
  FrameReport last_;
  std::pair<int64_t, int64_t> last_keyframe_{0, -1};
  StageTimes stage_ms_;
  IdCounter points_;
  IdCounter lines_;
};

}  // namespace plslam
