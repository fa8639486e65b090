// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/loop_log.h"

#include <algorithm>
#include <cmath>

namespace plslam::viewer {
namespace {

constexpr size_t kMaxCorrections = 40;

}  // namespace

void CorrectionLog::Add(const MapUpdate& update, const Map& map, FrameId frame_id) {
  // A complete map contains all past loops; their corrections were not observed. A removed keyframe passes on its loops
  // without any.
  const bool corrected =
      !update.IsWhole() && !update.loops.empty() && update.removed_keyframes.empty() && !positions_.empty();
  if (corrected) {
    Compare(map, frame_id);
    for (const LoopEdge& edge : update.loops) {
      moved_m_[{edge.old_keyframe_id, edge.keyframe_id}] = corrections_.empty() ? 0.0 : corrections_.back().moved_m;
    }
    KeepLargest();
  }
  if (update.IsWhole()) positions_.clear();
  Follow(update);
}

void CorrectionLog::Compare(const Map& map, FrameId frame_id) {
  ReportCorrection correction;
  correction.frame_id = frame_id;
  std::vector<int32_t> ids;
  std::vector<float> before, after;
  for (const auto& [id, p_before] : positions_) {
    const MapKeyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr) continue;
    const Eigen::Vector3d p_after = keyframe->T_w_kf.translation();
    ids.push_back(static_cast<int32_t>(id.value));
    Append(p_before, before);
    Append(p_after, after);
    correction.moved_m = std::max(correction.moved_m, (p_after - p_before).norm());
  }
  correction.table = {
      {"keyframe", 1, std::move(ids)}, {"before", 3, std::move(before)}, {"after", 3, std::move(after)}};
  corrections_.push_back(std::move(correction));
}

void CorrectionLog::KeepLargest() {
  if (corrections_.size() <= kMaxCorrections) return;
  const auto smaller = [](const auto& a, const auto& b) { return a.moved_m < b.moved_m; };
  corrections_.erase(std::min_element(corrections_.begin(), corrections_.end(), smaller));
  ++dropped_;
}

void CorrectionLog::Follow(const MapUpdate& update) {
  for (const MovedKeyframe& keyframe : update.moved_keyframes) {
    positions_.insert_or_assign(keyframe.id, keyframe.T_w_kf.translation());
  }
  for (const KeyframeId id : update.removed_keyframes) positions_.erase(id);
  for (const MapKeyframe& keyframe : update.keyframes) {
    positions_.insert_or_assign(keyframe.id, keyframe.T_w_kf.translation());
  }
}

double CorrectionLog::Moved_m(const LoopEdge& edge) const {
  const auto found = moved_m_.find({edge.old_keyframe_id, edge.keyframe_id});
  return found == moved_m_.end() ? 0.0 : found->second;
}

namespace {

constexpr size_t kMaxLoops = 2000;

FrameId FrameOf(const Map& map, KeyframeId keyframe_id) {
  const MapKeyframe* keyframe = map.FindKeyframe(keyframe_id);
  return keyframe == nullptr ? FrameId() : keyframe->frame_id;
}

}  // namespace

void LoopLog::Add(const LoopClosure& closure) {
  if (closure.kind != LoopClosure::Kind::kLoop || figures_.size() > 10 * kMaxLoops) return;
  closed_.insert(closure.keyframe);
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

}  // namespace plslam::viewer
