// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/run_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/files/atomic_file.h"
#include "core/io/maps/map_ply.h"
#include "core/run/final_trajectory.h"
#include "core/run/result_files.h"

namespace plslam {

namespace {

// The covariance of a perturbation in c, for the same perturbation in l, which has the same origin.
Matrix6d Rotate(const Matrix6d& covariance_c, const Eigen::Matrix3d& R_l_c) {
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = R_l_c;
  A.bottomRightCorner<3, 3>() = R_l_c;
  const Matrix6d rotated = A * covariance_c * A.transpose();
  return 0.5 * (rotated + rotated.transpose());
}

/// Files that are written beside each other. The first failure of each is kept, and the others go on.
class Attempts {
 public:
  template <class Write>
  bool Try(const Write& write) {
    try {
      write();
      return true;
    } catch (const std::exception& e) {
      failures_.emplace_back(e.what());
      return false;
    }
  }
  std::vector<std::string> TakeFailures() { return std::move(failures_); }

 private:
  std::vector<std::string> failures_;
};

/// One of these files, of a type with `PutInPlace`.
template <class Writer>
class Attempt {
 public:
  template <class... Arguments>
  explicit Attempt(Attempts& attempts, const Arguments&... arguments) : attempts_(attempts) {
    attempts_.Try([&] { writer_.emplace(arguments...); });
  }
  template <class Row>
  void Add(const Row& row) {
    if (writer_ && !attempts_.Try([&] { writer_->Add(row); })) writer_.reset();
  }
  void PutInPlace() {
    if (writer_) attempts_.Try([&] { writer_->PutInPlace(); });
  }

 private:
  Attempts& attempts_;
  std::optional<Writer> writer_;
};

std::string PathOf(const std::string& folder, const char* name) { return folder + "/" + name; }

/// A trajectory in the three formats.
class AllFormats {
 public:
  AllFormats(Attempts& attempts, const std::string& folder, const result_file::Trajectories& names)
      : tum_(attempts, PathOf(folder, names.tum), TrajectoryFormat::kTum),
        kitti_(attempts, PathOf(folder, names.kitti), TrajectoryFormat::kKitti),
        euroc_(attempts, PathOf(folder, names.euroc), TrajectoryFormat::kEuroc) {}
  void Add(const TrajectoryPose& pose) {
    tum_.Add(pose);
    kitti_.Add(pose);
    euroc_.Add(pose);
  }
  void PutInPlace() {
    tum_.PutInPlace();
    kitti_.PutInPlace();
    euroc_.PutInPlace();
  }

 private:
  Attempt<TrajectoryWriter> tum_, kitti_, euroc_;
};

/// A frame that has a pose, in l.
struct PosedFrame {
  TrajectoryPose final;  ///< in the final map
  std::optional<TrajectoryPose> live;
  bool keyframe = false;
  PoseCovariance covariance;
  std::optional<PoseCovariance> motion_covariance;
};

/// A run with its map, one part of which is visited or written.
struct RunPart {
  const Recorder& recorder;
  const Map& map;
  const Eigen::Quaterniond& q_l_c;
  const RunParts& parts;
  size_t part = 0;
};

void VisitPosedFrames(const RunPart& run, const std::function<void(const PosedFrame&)>& visit) {
  const auto& [recorder, map, q_l_c, parts, part] = run;
  const SE3 T_c_l(q_l_c.conjugate(), Eigen::Vector3d::Zero());
  const Eigen::Matrix3d R_l_c = q_l_c.toRotationMatrix();
  const FinalPoses final_poses(map, recorder);
  const LiveAnchors anchors(recorder);
  std::optional<int64_t> newest_ns;
  std::optional<SessionId> session_before;
  for (const auto& [frame_id, frame] : recorder.frames()) {
    const bool is_of_part = parts.Of(frame.session) == part;
    const bool usable = is_of_part && HasPose(frame) && (!newest_ns || frame.t_ns > *newest_ns);
    if (usable) {
      PosedFrame posed;
      posed.final = {frame.t_ns, final_poses(FrameId(frame_id), frame) * T_c_l};
      posed.keyframe = frame.keyframe_id >= 0;
      posed.covariance = {frame.t_ns, Rotate(frame.covariance.Unpack(), R_l_c)};
      if (anchors.Has(frame)) posed.live = {frame.t_ns, frame.T_w_odom * frame.T_odom_c * T_c_l};
      if (session_before == frame.session) {
        posed.motion_covariance = {frame.t_ns, Rotate(frame.motion_covariance.Unpack(), R_l_c)};
      }
      visit(posed);
      newest_ns = frame.t_ns;
    }
    session_before = usable ? std::optional(frame.session) : std::nullopt;
  }
}

void VisitTruth(const Recorder& recorder, const std::function<void(const TrajectoryPose&)>& visit) {
  std::optional<int64_t> newest_ns;
  for (const auto& [frame_id, truth] : recorder.truth()) {
    if (newest_ns && truth.t_ns <= *newest_ns) continue;
    visit({truth.t_ns, truth.T_w_l});
    newest_ns = truth.t_ns;
  }
}

Trajectory MapKeyframes(const RunPart& run) {
  Trajectory keyframes = KeyframeTrajectory(run.parts.MapOf(run.part), run.recorder);
  const SE3 T_c_l(run.q_l_c.conjugate(), Eigen::Vector3d::Zero());
  for (TrajectoryPose& pose : keyframes) pose.T_a_b = pose.T_a_b * T_c_l;
  return keyframes;
}

}  // namespace

Run RunOf(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c, size_t part) {
  Trajectory all, live, truth;
  std::vector<PoseCovariance> covariances, motion_covariances;
  const RunParts parts(map, recorder);
  const RunPart run{recorder, map, q_l_c, parts, part};
  Trajectory keyframes = MapKeyframes(run);
  VisitPosedFrames(run, [&](const PosedFrame& frame) {
    all.push_back(frame.final);
    if (frame.live) live.push_back(*frame.live);
    if (frame.keyframe && map.keyframes().empty()) keyframes.push_back(frame.final);
    covariances.push_back(frame.covariance);
    if (frame.motion_covariance) motion_covariances.push_back(*frame.motion_covariance);
  });
  VisitTruth(recorder, [&](const TrajectoryPose& pose) { truth.push_back(pose); });
  Run result;
  result.trajectory = std::move(all);
  result.live = std::move(live);
  result.keyframes = std::move(keyframes);
  if (!recorder.truth().empty()) result.truth = std::move(truth);
  result.covariance = std::move(covariances);
  result.motion_covariance = std::move(motion_covariances);
  return result;
}

namespace {

std::vector<std::string> ColumnsOf(const Recorder& recorder) {
  std::vector<std::string> columns{
      "frame_id",        "t_s",         "state",         "n_points",       "n_lines",  "n_tracked_points",
      "n_tracked_lines", "keyframe_id", "entropy_ratio", "skipped_frames", "n_moving", "anchored"};
  for (std::string name : recorder.stage_names()) {
    // Names are received from the network; a comma or quote in one must not shift the columns.
    std::ranges::replace_if(
        name, [](char c) { return c == ',' || c == '"' || c == '\n' || c == '\r'; }, '_');
    columns.push_back(name + "_ms");
  }
  return columns;
}

FrameTable::Row RowOf(FrameId frame_id, const FrameRecord& frame, size_t n_stages) {
  const FrameCounts& n = frame.counts;
  FrameTable::Row row{
      frame.t_ns,
      {fmt::to_string(frame_id.value), SecondsText(frame.t_ns), TrackingStateName(frame.state),
       fmt::to_string(n.points), fmt::to_string(n.lines), fmt::to_string(n.tracked_points),
       fmt::to_string(n.tracked_lines), fmt::to_string(frame.keyframe_id), fmt::format("{:.6g}", frame.entropy_ratio),
       fmt::to_string(n.skipped_frames), fmt::to_string(n.moving), fmt::format("{:d}", frame.anchored)}};
  for (size_t i = 0; i < n_stages; ++i) {
    const bool known = i < frame.stages_ms.size() && std::isfinite(frame.stages_ms[i]);
    row.values.push_back(known ? fmt::format("{:.4f}", frame.stages_ms[i]) : "");
  }
  return row;
}

}  // namespace

FrameTable FrameTableOf(const Recorder& recorder) {
  FrameTable table{ColumnsOf(recorder), {}};
  for (const auto& [frame_id, frame] : recorder.frames())
    table.rows.push_back(RowOf(FrameId(frame_id), frame, recorder.stage_names().size()));
  return table;
}

void WritePosesCsv(const Recorder& recorder, const AppendText& append) {
  append(fmt::format("{}\n", fmt::join(ColumnsOf(recorder), ",")));
  for (const auto& [frame_id, frame] : recorder.frames()) {
    const FrameTable::Row row = RowOf(FrameId(frame_id), frame, recorder.stage_names().size());
    append(fmt::format("{}\n", fmt::join(row.values, ",")));
  }
}

void WriteBodiesCsv(const Recorder& recorder, const Map& map, const AppendText& append) {
  append("session,body,frame_id,t_s,x_m,y_m,z_m,qx,qy,qz,qw,n_features\n");
  const FinalPoses final_poses(map, recorder);
  for (const auto& [frame_id, seen] : recorder.bodies()) {
    const std::optional<FrameRecord> frame = recorder.frames().Find(frame_id.value);
    if (!frame || !HasPose(*frame) || frame->session != seen.session) continue;
    const SE3 T_w_c = final_poses(frame_id, *frame);
    for (const BodyRecord& body : seen.bodies) {
      const SE3 T_w_body = T_w_c * body.T_c_body;
      const Eigen::Vector3d& t = T_w_body.translation();
      const Eigen::Quaterniond& q = T_w_body.rotation();
      append(fmt::format("{},{},{},{},{:.6f},{:.6f},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f},{}\n", frame->session, body.id,
                         frame_id, SecondsText(frame->t_ns), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w(),
                         body.n_features));
    }
  }
}

void PrepareOutputFolder(const std::string& folder) {
  MakeFolder(folder);
  const std::string probe = folder + "/.write_test";
  WriteFileAtomically(probe, "checks whether this folder is writable\n");
  std::remove(probe.c_str());
}

void CheckHasNoResults(const std::string& folder) {
  for (const char* name : kResultFiles) {
    if (!std::filesystem::exists(std::filesystem::path(folder) / name)) continue;
    throw std::runtime_error(fmt::format(
        "{}: has results of an earlier run ({}): give another --out, or --force to replace them", folder, name));
  }
}

void RemoveResults(const std::string& folder) {
  const std::filesystem::path all(folder);
  std::error_code ignored;
  for (const char* name : kResultFiles) std::filesystem::remove(all / name, ignored);
  for (const auto& entry : std::filesystem::directory_iterator(all / "overlays", ignored)) {
    if (entry.path().extension() == ".png") std::filesystem::remove(entry.path(), ignored);
  }
}

namespace {

std::string FolderOfPart(const std::string& folder, size_t part) {
  return fmt::format("{}/part{}", folder, part + 1);
}

/// Removes the parts of an earlier state of the map, or of an earlier run.
void RemoveParts(const std::string& folder) {
  for (size_t part = 1; std::filesystem::is_directory(FolderOfPart(folder, part)); ++part) {
    RemoveResults(FolderOfPart(folder, part));
    std::error_code is_not_empty;
    std::filesystem::remove(FolderOfPart(folder, part), is_not_empty);
  }
}

/// A trajectory in the three formats, of which there are no files without poses.
class FormatsIfAny {
 public:
  FormatsIfAny(Attempts& attempts, std::string folder, const result_file::Trajectories& names)
      : attempts_(attempts), folder_(std::move(folder)), names_(names) {}
  void Add(const TrajectoryPose& pose) {
    if (!files_) files_.emplace(attempts_, folder_, names_);
    files_->Add(pose);
  }
  void PutInPlace() {
    if (files_) files_->PutInPlace();
  }

 private:
  Attempts& attempts_;
  std::string folder_;
  result_file::Trajectories names_;
  std::optional<AllFormats> files_;
};

/// A part that is not the main one has a frame of its own, and only trajectories and landmarks.
void WritePart(const std::string& folder, const RunPart& run, Attempts& attempts) {
  FormatsIfAny all(attempts, folder, result_file::kTrajectory);
  FormatsIfAny keyframes(attempts, folder, result_file::kKeyframes);
  for (const TrajectoryPose& pose : MapKeyframes(run)) keyframes.Add(pose);
  VisitPosedFrames(run, [&](const PosedFrame& frame) { all.Add(frame.final); });
  all.PutInPlace();
  keyframes.PutInPlace();
  attempts.Try(
      [&] { WriteFileAtomically(PathOf(folder, result_file::kLandmarks), MapPly(run.parts.MapOf(run.part))); });
}

void WriteMainPart(const std::string& folder, const RunPart& run, Attempts& attempts) {
  AllFormats all(attempts, folder, result_file::kTrajectory);
  Attempt<TrajectoryWriter> live(attempts, PathOf(folder, result_file::kLiveTrajectory), TrajectoryFormat::kTum);
  AllFormats keyframes(attempts, folder, result_file::kKeyframes);
  Attempt<PoseCovarianceWriter> covariances(attempts, PathOf(folder, result_file::kCovariances));
  Attempt<PoseCovarianceWriter> motion_covariances(attempts, PathOf(folder, result_file::kMotionCovariances));
  for (const TrajectoryPose& pose : MapKeyframes(run)) keyframes.Add(pose);
  const bool has_map = !run.map.keyframes().empty();
  VisitPosedFrames(run, [&](const PosedFrame& frame) {
    all.Add(frame.final);
    if (frame.live) live.Add(*frame.live);
    if (frame.keyframe && !has_map) keyframes.Add(frame.final);
    covariances.Add(frame.covariance);
    if (frame.motion_covariance) motion_covariances.Add(*frame.motion_covariance);
  });
  all.PutInPlace();
  live.PutInPlace();
  keyframes.PutInPlace();
  covariances.PutInPlace();
  motion_covariances.PutInPlace();
  if (has_map)
    attempts.Try([&] { WriteFileAtomically(PathOf(folder, result_file::kLandmarks), MapPly(run.parts.MapOf(0))); });
}

void WriteText(const std::string& path, const std::function<void(const AppendText&)>& write) {
  AtomicFile file(path);
  write([&file](std::string_view text) { file.Append(text); });
  file.PutInPlace();
}

}  // namespace

std::vector<std::string> WriteOutputs(const std::string& folder, const Recorder& recorder, const Map& map,
                                      const Eigen::Quaterniond& q_l_c) {
  Attempts attempts;
  const RunParts parts(map, recorder);
  WriteMainPart(folder, {recorder, map, q_l_c, parts, 0}, attempts);
  if (!recorder.truth().empty()) {
    Attempt<TrajectoryWriter> truth(attempts, PathOf(folder, result_file::kTruth), TrajectoryFormat::kTum);
    VisitTruth(recorder, [&](const TrajectoryPose& pose) { truth.Add(pose); });
    truth.PutInPlace();
  }
  attempts.Try([&] {
    WriteText(PathOf(folder, result_file::kFrameTable), [&](const AppendText& to) { WritePosesCsv(recorder, to); });
  });
  attempts.Try([&] {
    WriteText(PathOf(folder, result_file::kBodies), [&](const AppendText& to) { WriteBodiesCsv(recorder, map, to); });
  });
  RemoveParts(folder);
  for (size_t part = 1; part < parts.size(); ++part) {
    const std::string of_part = FolderOfPart(folder, part);
    if (attempts.Try([&] { MakeFolder(of_part); })) WritePart(of_part, {recorder, map, q_l_c, parts, part}, attempts);
  }
  return attempts.TakeFailures();
}

}  // namespace plslam
