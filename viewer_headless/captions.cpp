// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/captions.h"

#include <fmt/format.h>

namespace plslam::viewer {

std::string ProgressLine(const Recorder& recorder, const ProgressNumbers& numbers) {
  std::string line = fmt::format("frame {}", recorder.frames().size());
  if (numbers.announced_frames >= 0) line += fmt::format("/{}", numbers.announced_frames);
  line += fmt::format("  {:.1f}/s", numbers.frames_per_s);
  if (recorder.frames().empty()) return line + "  waiting";
  const FrameRecord newest = recorder.frames().Last().second;
  line += fmt::format("  {} points  {} lines  keyframes {}  {}", newest.counts.tracked_points,
                      newest.counts.tracked_lines, recorder.keyframes(), TrackingStateName(newest.state));
  const FrameTally tally = recorder.Tally(false);
  if (tally.lost > 0) line += fmt::format("  lost {}", tally.lost);
  if (tally.skipped > 0) line += fmt::format("  skipped {}", tally.skipped);
  line += fmt::format("  gaps {}", numbers.gaps);
  if (numbers.gaps > 0) line += fmt::format(" ({} repaired)", numbers.repaired);
  return line;
}

std::string FrameCaption(const FramePose& pose) {
  std::string caption =
      fmt::format("frame {}  {}  points {}/{}  lines {}/{}", pose.frame_id, TrackingStateName(pose.state),
                  pose.counts.tracked_points, pose.counts.points, pose.counts.tracked_lines, pose.counts.lines);
  if (pose.keyframe_id >= 0) caption += fmt::format("  keyframe {}", pose.keyframe_id);
  return caption;
}

}  // namespace plslam::viewer
