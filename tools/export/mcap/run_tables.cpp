// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/mcap/run_tables.h"

#include <filesystem>

#include "core/io/files/text_rows.h"
#include "core/io/trajectories/pose_covariance.h"

namespace plslam::exports {
namespace {

namespace fs = std::filesystem;

std::map<int64_t, Matrix6d> ReadCovariances(const fs::path& path) {
  std::map<int64_t, Matrix6d> covariances;
  if (!fs::exists(path)) return covariances;
  for (const PoseCovariance& pose : ReadPoseCovariances(path.string())) covariances[pose.t_ns] = pose.covariance;
  return covariances;
}

Trajectory ReadPoses(const fs::path& path) {
  return fs::exists(path) ? ReadTrajectory(path.string(), TrajectoryFormat::kTum) : Trajectory();
}

int LevelOf(std::string_view state) {
  if (state == "lost") return 2;
  return state == "tracking" ? 0 : 1;
}

std::vector<RosDiagnostic> ReadFrames(const fs::path& path) {
  std::vector<RosDiagnostic> frames;
  if (!fs::exists(path)) return frames;
  std::vector<std::string> names;
  ForEachRow(path.string(), [&](const TextRow& row) {
    if (names.empty()) {
      names.assign(row.fields.begin(), row.fields.end());
      return;
    }
    // frame_id, t_s and state, then the other values of the frame.
    constexpr size_t kTime = 1, kState = 2;
    if (row.fields.size() != names.size() || names.size() <= kState)
      row.Fail("does not have the columns of the first line");
    RosDiagnostic frame;
    frame.t_ns = row.Scaled(kTime, 9);
    frame.level = LevelOf(row.fields[kState]);
    frame.name = "vo_process";
    frame.message = row.fields[kState];
    for (size_t i = 0; i < names.size(); ++i) {
      if (i != kTime && i != kState) frame.values.emplace_back(names[i], row.fields[i]);
    }
    frames.push_back(std::move(frame));
  });
  return frames;
}

}  // namespace

RunTables ReadRunTables(const std::string& folder) {
  const fs::path path(folder);
  return {ReadPoses(path / "trajectory_live.tum"), ReadPoses(path / "groundtruth.tum"),
          ReadCovariances(path / "covariance.txt"), ReadCovariances(path / "motion_covariance.txt"),
          ReadFrames(path / "poses.csv")};
}

}  // namespace plslam::exports
