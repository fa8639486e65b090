// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/run/recorder.h"

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

}  // namespace plslam::viewer
