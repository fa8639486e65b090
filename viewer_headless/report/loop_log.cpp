// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/loop_log.h"

#include <cmath>

namespace plslam {
namespace {

constexpr size_t kMaxLoops = 2000;

int64_t FrameOf(const Map& map, int64_t keyframe_id) {
  const MapKeyframe* keyframe = map.FindKeyframe(keyframe_id);
  return keyframe == nullptr ? -1 : keyframe->frame_id;
}

}  // namespace

void LoopLog::Add(const LoopClosure& closure) {
  if (closure.kind != LoopClosure::Kind::kLoop || figures_.size() > 10 * kMaxLoops) return;
  closed_.emplace(closure.session, closure.session_keyframe_id);
  for (const LoopEdge& edge : closure.edges) {
    figures_[{edge.old_keyframe_id, edge.keyframe_id}] = {closure.score, closure.detect_ms, closure.correct_ms};
  }
}

std::vector<ReportLoop> LoopLog::Loops(const Map& map, const CorrectionLog& corrections,
                                       const PictureStore& pictures) const {
  std::vector<ReportLoop> loops;
  const size_t n = map.loops().size();
  for (size_t i = n > kMaxLoops ? n - kMaxLoops : 0; i < n; ++i) {
    const LoopEdge& edge = map.loops()[i];
    ReportLoop loop;
    loop.old_keyframe_id = edge.old_keyframe_id;
    loop.keyframe_id = edge.keyframe_id;
    loop.old_frame_id = FrameOf(map, edge.old_keyframe_id);
    loop.frame_id = FrameOf(map, edge.keyframe_id);
    loop.n_points = edge.n_points;
    loop.n_lines = edge.n_lines;
    loop.distance_m = edge.T_old_kf.translation().norm();
    loop.angle_deg = edge.T_old_kf.rotation().angularDistance(Eigen::Quaterniond::Identity()) * 180.0 / M_PI;
    loop.moved_m = corrections.Moved_m(edge);
    const auto found = figures_.find({edge.old_keyframe_id, edge.keyframe_id});
    if (found != figures_.end()) {
      loop.score = found->second.score;
      loop.detect_ms = found->second.detect_ms;
      loop.correct_ms = found->second.correct_ms;
    }
    if (n - i <= kMaxLoopPictures) {
      loop.old_jpeg = pictures.Keyframe(loop.old_frame_id);
      loop.jpeg = pictures.Keyframe(loop.frame_id);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

}  // namespace plslam
