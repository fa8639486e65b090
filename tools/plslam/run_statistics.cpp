#include "tools/plslam/run_statistics.h"

namespace plslam {

std::string TrackingStateName(int state) {
  static const char* const kNames[] = {"initialising", "tracking", "weak", "lost", "recovered"};
  return state >= 0 && state < 5 ? kNames[state] : "unknown";
}

void RunStatistics::AddFrame(const FrameReport& frame) {
  last_ = frame;
  // A tracker that was started again answers frames again.
  if (frame.frame_id <= newest_frame_id_) return;
  for (const auto& [stage, ms] : frame.stage_ms) stage_ms_.Add(stage, ms);
  skipped_frames_ += frame.skipped_frames;
  if (frame.keyframe_id >= 0) {
    ++keyframes_;
    last_keyframe_ = {frame.session, frame.keyframe_id};
  }
  newest_frame_id_ = frame.frame_id;
  newest_t_ns_ = frame.t_ns;
  ++frames_;
  const bool estimated = frame.state == 1 || frame.state == 2 || frame.state == 4;
  if (estimated || (frame.state == 0 && frame.keyframe_id >= 0)) ++tracked_frames_;
}

void RunStatistics::AddLandmark(int64_t session, int64_t landmark_id, bool is_line) {
  (is_line ? lines_ : points_).Add(session, landmark_id);
}

}  // namespace plslam
