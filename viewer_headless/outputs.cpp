// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/outputs.h"

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "core/io/files/atomic_file.h"
#include "core/io/maps/map_ply.h"
#include "viewer_headless/final_trajectory.h"

namespace plslam::viewer {

std::string ProgressLine(const Recorder& recorder, const ProgressNumbers& numbers) {
  std::string line = fmt::format("frame {}", recorder.frames().size());
  if (numbers.announced_frames >= 0) line += fmt::format("/{}", numbers.announced_frames);
  line += fmt::format("  {:.1f}/s", numbers.frames_per_s);
  if (recorder.frames().empty()) return line + "  waiting";
  const FrameRecord& newest = recorder.frames().rbegin()->second;
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

namespace {

bool IsAfterLast(const Trajectory& trajectory, int64_t t_ns) {
  return trajectory.empty() || t_ns > trajectory.back().t_ns;
}

// The covariance of a perturbation in c, for the same perturbation in l, which has the same origin.
Matrix6d Rotate(const Matrix6d& covariance_c, const Eigen::Matrix3d& R_l_c) {
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = R_l_c;
  A.bottomRightCorner<3, 3>() = R_l_c;
  const Matrix6d rotated = A * covariance_c * A.transpose();
  return 0.5 * (rotated + rotated.transpose());
}

/// Tries to write files, one after the other.
class Attempts {
 public:
  template <class Write>
  void Try(const Write& write) {
    try {
      write();
    } catch (const std::exception& e) {
      failures_.emplace_back(e.what());
    }
  }
  void Trajectory(const std::string& path, TrajectoryFormat format, const plslam::Trajectory& trajectory) {
    Try([&] { WriteTrajectory(path, format, trajectory); });
  }
  void AllFormats(const std::string& stem, const plslam::Trajectory& trajectory) {
    Trajectory(stem + ".tum", TrajectoryFormat::kTum, trajectory);
    Trajectory(stem + ".kitti", TrajectoryFormat::kKitti, trajectory);
    Trajectory(stem + ".euroc", TrajectoryFormat::kEuroc, trajectory);
  }
  std::vector<std::string> TakeFailures() { return std::move(failures_); }

 private:
  std::vector<std::string> failures_;
};

}  // namespace

RunTrajectories BuildTrajectories(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c) {
  RunTrajectories result;
  const SE3 T_c_l(q_l_c.conjugate(), Eigen::Vector3d::Zero());
  const Eigen::Matrix3d R_l_c = q_l_c.toRotationMatrix();
  const FinalPoses final_poses(map, recorder);
  const LiveAnchors anchors(recorder);
  const FrameRecord* previous = nullptr;
  for (const auto& [frame_id, frame] : recorder.frames()) {
    const bool usable = HasPose(frame) && IsAfterLast(result.all, frame.t_ns);
    if (usable) {
      result.all.push_back({frame.t_ns, final_poses(frame_id, frame) * T_c_l});
      if (anchors.Has(frame)) result.live.push_back({frame.t_ns, frame.T_w_odom * frame.T_odom_c * T_c_l});
      if (frame.keyframe_id >= 0 && map.keyframes().empty()) result.keyframes.push_back(result.all.back());
      result.covariances.push_back({frame.t_ns, Rotate(frame.covariance.Unpack(), R_l_c)});
      if (previous != nullptr && previous->session == frame.session) {
        result.motion_covariances.push_back({frame.t_ns, Rotate(frame.motion_covariance.Unpack(), R_l_c)});
      }
    }
    previous = usable ? &frame : nullptr;
  }
  for (const TrajectoryPose& pose : KeyframeTrajectory(map, recorder)) {
    result.keyframes.push_back({pose.t_ns, pose.T_a_b * T_c_l});
  }
  for (const auto& [frame_id, truth] : recorder.truth()) {
    if (IsAfterLast(result.truth, truth.t_ns)) result.truth.push_back({truth.t_ns, truth.T_w_l});
  }
  return result;
}

std::string PosesCsv(const Recorder& recorder) {
  std::string text =
      "frame_id,t_s,state,n_points,n_lines,n_tracked_points,n_tracked_lines,keyframe_id,entropy_ratio,skipped_frames,"
      "n_moving";
  for (const std::string& name : recorder.stage_names()) {
    text += ',';
    // Names are received from the network; a comma or quote in one must not shift the columns.
    for (const char c : name) text += c == ',' || c == '"' || c == '\n' || c == '\r' ? '_' : c;
    text += "_ms";
  }
  text += '\n';
  const auto out = std::back_inserter(text);
  for (const auto& [frame_id, frame] : recorder.frames()) {
    const FrameCounts& n = frame.counts;
    fmt::format_to(out, "{},{},{},{},{},{},{},{},{:.6g},{},{}", frame_id, SecondsText(frame.t_ns),
                   TrackingStateName(frame.state), n.points, n.lines, n.tracked_points, n.tracked_lines,
                   frame.keyframe_id, frame.entropy_ratio, n.skipped_frames, n.moving);
    for (size_t i = 0; i < recorder.stage_names().size(); ++i) {
      text += ',';
      const bool known = i < frame.stages_ms.size() && std::isfinite(frame.stages_ms[i]);
      if (known) fmt::format_to(out, "{:.4f}", frame.stages_ms[i]);
    }
    text += '\n';
  }
  return text;
}

std::string BodiesCsv(const Recorder& recorder, const Map& map) {
  std::string text = "session,body,frame_id,t_s,x_m,y_m,z_m,qx,qy,qz,qw,n_features\n";
  const auto out = std::back_inserter(text);
  const FinalPoses final_poses(map, recorder);
  for (const auto& [frame_id, seen] : recorder.bodies()) {
    const auto frame = recorder.frames().find(frame_id);
    if (frame == recorder.frames().end() || !HasPose(frame->second) || frame->second.session != seen.session)
      continue;
    const SE3 T_w_c = final_poses(frame_id, frame->second);
    for (const BodyRecord& body : seen.bodies) {
      const SE3 T_w_body = T_w_c * body.T_c_body;
      const Eigen::Vector3d& t = T_w_body.translation();
      const Eigen::Quaterniond& q = T_w_body.rotation();
      fmt::format_to(out, "{},{},{},{},{:.6f},{:.6f},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f},{}\n", frame->second.session,
                     body.id, frame_id, SecondsText(frame->second.t_ns), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                     q.w(), body.n_features);
    }
  }
  return text;
}

void PrepareOutputFolder(const std::string& folder) {
  MakeFolder(folder);
  const std::string probe = folder + "/.write_test";
  WriteFileAtomically(probe, "checks whether this folder is writable\n");
  std::remove(probe.c_str());
}

std::vector<std::string> WriteOutputs(const std::string& folder, const Recorder& recorder, const Map& map,
                                      const Eigen::Quaterniond& q_l_c) {
  const RunTrajectories run = BuildTrajectories(recorder, map, q_l_c);
  Attempts attempts;
  attempts.AllFormats(folder + "/trajectory", run.all);
  attempts.Trajectory(folder + "/trajectory_live.tum", TrajectoryFormat::kTum, run.live);
  attempts.AllFormats(folder + "/keyframes", run.keyframes);
  if (!run.truth.empty()) attempts.Trajectory(folder + "/groundtruth.tum", TrajectoryFormat::kTum, run.truth);
  attempts.Try([&] { WritePoseCovariances(folder + "/covariance.txt", run.covariances); });
  attempts.Try([&] { WritePoseCovariances(folder + "/motion_covariance.txt", run.motion_covariances); });
  attempts.Try([&] { WriteFileAtomically(folder + "/poses.csv", PosesCsv(recorder)); });
  attempts.Try([&] { WriteFileAtomically(folder + "/bodies.csv", BodiesCsv(recorder, map)); });
  if (!map.keyframes().empty()) attempts.Try([&] { WriteFileAtomically(folder + "/map.ply", MapPly(map)); });
  return attempts.TakeFailures();
}

}  // namespace plslam::viewer
