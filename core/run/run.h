// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/files/notes.h"
#include "core/io/maps/map_file.h"
#include "core/io/trajectories/pose_covariance.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {

/// The frames of a run, lost ones included, as text: `poses.csv`.
struct FrameTable {
  static constexpr size_t kTime = 1, kState = 2;  ///< columns
  struct Row {
    int64_t t_ns = 0;
    std::vector<std::string> values;
  };
  std::vector<std::string> columns;  ///< "frame_id", time, state, counts, and times of stages
  std::vector<Row> rows;
};

/// The outputs of a run; what it did not write is nullopt. Members are those of `Run` in Python (run.py). Poses are
/// T_w_l: l is the left camera as calibrated, w the final map. docs/viewer.md describes the files.
struct Run {
  std::string folder;    ///< empty: the run is not from a folder
  std::string map_path;  ///< empty: there is no map
  std::optional<nlohmann::json> summary;
  std::optional<Trajectory> trajectory;
  std::optional<Trajectory> live;  ///< as published
  std::optional<Trajectory> keyframes;
  std::optional<Trajectory> truth;
  /// Covariances of `trajectory`, and of the motion from the previous pose at the time of the later one.
  std::optional<std::vector<PoseCovariance>> covariance, motion_covariance;
  std::optional<FrameTable> frames;
  std::optional<StoredMap> map;
  Notes notes;  ///< about what is missing; files have none

  bool has_poses() const { return trajectory && !trajectory->empty(); }
};

/// Contents of a run that a reader needs, joined by `|`.
namespace run_content {
inline constexpr unsigned kSummary = 1, kTrajectory = 2, kLive = 4, kKeyframes = 8, kTruth = 16, kCovariances = 32,
                          kFrames = 64, kMap = 128;
}  // namespace run_content

/// Reads `content` of a run: `path` is its folder, or a map file (.plmap). The map of a folder is `map`, or else the
/// only map file there. Throws std::runtime_error with one sentence, which names file and line: if `path` does not
/// exist; if a file is damaged; if the folder has several maps, a map of another run than its summary's, or, where both
/// are requested, neither map nor poses.
Run ReadRun(const std::string& path, unsigned content, const std::string& map = "");

}  // namespace plslam
