// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_statistics.h"

#include <algorithm>

namespace plslam {

void RunStatistics::AddFrame(const FrameReport& frame) {
  last_ = frame;
  // A tracker that was started again answers frames again.
  if (frame.frame_id <= newest_frame_id_) return;
  for (const auto& [stage, ms] : frame.stage_ms) stage_ms_.Add(stage, ms);
  // No more than there is room for since the frame before, whatever is said.
  const int64_t between = frame.frame_id - newest_frame_id_ - 1;
  frames_.skipped += std::clamp<int64_t>(frame.skipped_frames, 0, between);
  if (frame.keyframe_id >= 0) {
    ++keyframes_;
    last_keyframe_ = {frame.session, frame.keyframe_id};
  }
  newest_frame_id_ = frame.frame_id;
  newest_t_ns_ = frame.t_ns;
  moving_.Add(frame.frame_id, frame.moving, frame.features, frame.bodies);
  frames_.Count(frame.state, frame.keyframe_id);
}

void RunStatistics::AddLandmark(int64_t session, int64_t landmark_id, bool is_line) {
  (is_line ? lines_ : points_).Add(session, landmark_id);
}

}  // namespace plslam
