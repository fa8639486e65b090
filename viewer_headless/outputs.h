// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/trajectories/pose_covariance.h"
#include "core/io/trajectories/trajectory.h"
#include "core/map/map.h"
#include "viewer_headless/recorder.h"

namespace plslam::viewer {

/// Numbers of the progress line beside the recording.
struct ProgressNumbers {
  int64_t announced_frames = -1;  ///< -1: unknown
  double frames_per_s = 0.0;
  int64_t gaps = 0;  ///< messages missed on the wire
  int64_t repaired = 0;
};

/// "frame 120/400  18.3/s  312 points  84 lines  keyframes 9  tracking  gaps 2 (2 repaired)": the newest frame.
std::string ProgressLine(const Recorder& recorder, const ProgressNumbers& numbers);

/// "frame 120  tracking  points 312/800  lines 84/120  keyframe 9": of one frame, for its picture.
std::string FrameCaption(const FramePose& pose);

/// The trajectories and covariances in the output files; l is the left camera as calibrated. Frames with state lost
/// have no pose of their own and appear only in `poses.csv`. A frame whose time is not after that of the previous one
/// is left out too.
struct RunTrajectories {
  Trajectory all;        ///< T_w_l of every frame in the final map (FinalPoses)
  Trajectory live;       ///< of the same frames as published
  Trajectory keyframes;  ///< of the map's keyframes; without a map, of frames that became keyframes
  Trajectory truth;      ///< true T_w_l
  /// Covariances of `all`, of the right perturbation in l.
  std::vector<PoseCovariance> covariances;
  /// Covariances of the motion between neighbours of `all` that are neighbours in the recording too, at the time of the
  /// later one.
  std::vector<PoseCovariance> motion_covariances;
};

/// `q_l_c` rotates directions of the rectified left camera c into l. A `map` without keyframes counts as no map.
/// Only of one part, if the map has unconnected ones (`RunParts`): the main one is 0.
RunTrajectories BuildTrajectories(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c,
                                  size_t part = 0);

/// Takes the next part of a text.
using AppendText = std::function<void(std::string_view)>;

/// One row for each frame, lost ones included: time, state, counts, stage times.
void WritePosesCsv(const Recorder& recorder, const AppendText& append);

/// One row for each moving body in each frame: T_w_body in the map as it is at the end; the body's frame as in body_t.
void WriteBodiesCsv(const Recorder& recorder, const Map& map, const AppendText& append);

/// Makes the folder and proves that files can be written there. Throws std::runtime_error.
void PrepareOutputFolder(const std::string& folder);

/// Throws std::runtime_error with one sentence if the folder has results of a run (`kResultFiles`).
void CheckHasNoResults(const std::string& folder);
/// Removes the results of a run from its folder, with its pictures of features.
void RemoveResults(const std::string& folder);

/// Writes all files of docs/viewer.md but the pictures, each whole or not at all, frame by frame: memory does not grow
/// with the length of the run. Tries each, and returns a sentence for each that could not be written.
std::vector<std::string> WriteOutputs(const std::string& folder, const Recorder& recorder, const Map& map,
                                      const Eigen::Quaterniond& q_l_c);

}  // namespace plslam::viewer
