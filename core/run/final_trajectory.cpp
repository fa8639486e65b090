// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/final_trajectory.h"

#include <algorithm>
#include <iterator>
#include <set>

namespace plslam {

std::map<SessionId, FrameCorrections> CorrectionsBySession(const Map& map) {
  std::map<SessionId, FrameCorrections> corrections;
  for (const auto& [id, keyframe] : map.keyframes()) {
    corrections[keyframe.name.session].insert_or_assign(keyframe.frame_id,
                                                        keyframe.T_w_kf * keyframe.T_odom_kf.Inverse());
  }
  for (const RemovedKeyframe& removed : map.RemovedKeyframes()) {
    corrections[removed.session].try_emplace(removed.frame_id, removed.T_w_kf * removed.T_odom_kf.Inverse());
  }
  return corrections;
}

LiveAnchors::LiveAnchors(const Recorder& recorder) {
  for (const auto& [frame_id, frame] : recorder.frames()) {
    if (frame.anchored) first_.try_emplace(frame.session, frame.T_w_odom);
  }
}

bool LiveAnchors::Has(const FrameRecord& frame) const {
  if (frame.anchored || first_.empty()) return true;
  const auto first = first_.find(frame.session);
  // The map may have been adjusted between the two frames.
  constexpr double kSame = 0.02;
  return first != first_.end() && (first->second.Inverse() * frame.T_w_odom).Log().norm() < kSame;
}

FinalPoses::FinalPoses(const Map& map, const Recorder& recorder) : corrections_(CorrectionsBySession(map)) {
  for (const auto& [frame_id, frame] : recorder.frames()) {
    if (frame.state == TrackingState::kLost) lost_frames_.insert(FrameId(frame_id));
  }
}

SE3 FinalPoses::operator()(FrameId frame_id, const FrameRecord& frame) const {
  const auto session = corrections_.find(frame.session);
  if (session == corrections_.end()) return frame.T_w_odom * frame.T_odom_c;
  const FrameCorrections& corrections = session->second;
  const auto after = corrections.lower_bound(frame_id);
  if (after == corrections.begin() || (after != corrections.end() && after->first == frame_id)) {
    return after->second * frame.T_odom_c;
  }
  const auto before = std::prev(after);
  SE3 T_before = before->second * frame.T_odom_c;
  if (after == corrections.end()) return T_before;
  const SE3 T_after = after->second * frame.T_odom_c;
  const auto lost = lost_frames_.lower_bound(before->first);
  if (lost != lost_frames_.end() && *lost < after->first) return frame_id < *lost ? T_before : T_after;
  const double share = static_cast<double>(frame_id.value - before->first.value) /
                       static_cast<double>(after->first.value - before->first.value);
  return SE3(T_before.rotation().slerp(share, T_after.rotation()),
             (1.0 - share) * T_before.translation() + share * T_after.translation());
}

namespace {

std::set<SessionId> SessionsOf(const Recorder& recorder) {
  std::set<SessionId> sessions;
  for (const auto& [frame_id, frame] : recorder.frames()) sessions.insert(frame.session);
  return sessions;
}

}  // namespace

RunParts::RunParts(const Map& map, const Recorder& recorder) : map_(&map) {
  const std::set<SessionId> sessions = SessionsOf(recorder);
  const auto parts =
      PartsOf(map, [&](const MapKeyframe& keyframe) { return sessions.contains(keyframe.name.session); });
  if (parts.size() < 2) return;
  for (size_t part = 0; part < parts.size(); ++part) {
    for (const KeyframeId id : parts[part]) part_of_session_.try_emplace(map.FindKeyframe(id)->name.session, part);
    parts_.push_back(PartOf(map, parts[part]));
  }
}

size_t RunParts::Of(SessionId session) const {
  const auto found = part_of_session_.find(session);
  return found == part_of_session_.end() ? 0 : found->second;
}

Trajectory KeyframeTrajectory(const Map& map, const Recorder& recorder) {
  const std::set<SessionId> sessions = SessionsOf(recorder);
  Trajectory trajectory;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (sessions.contains(keyframe.name.session)) trajectory.push_back({keyframe.t_ns, keyframe.T_w_kf});
  }
  const auto earlier = [](const TrajectoryPose& a, const TrajectoryPose& b) { return a.t_ns < b.t_ns; };
  const auto same = [](const TrajectoryPose& a, const TrajectoryPose& b) { return a.t_ns == b.t_ns; };
  std::stable_sort(trajectory.begin(), trajectory.end(), earlier);
  trajectory.erase(std::unique(trajectory.begin(), trajectory.end(), same), trajectory.end());
  return trajectory;
}

}  // namespace plslam
