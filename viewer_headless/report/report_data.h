// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/vertical.h"
#include "core/run/run_warnings.h"
#include "viewer_headless/overlay.h"
#include "viewer_headless/report/table.h"

namespace plslam::viewer {

/// What the head of the report says.
struct RunFacts {
  std::string dataset;
  std::string pace;
  std::string version;
  bool finished = false;
  int64_t announced_frames = -1;  ///< -1: unknown
  std::optional<StereoCamera> camera;
  FrameTally frames;
  MovingTally moving;
  int64_t keyframes = 0;
  int64_t points = 0;  ///< landmarks of the map
  int64_t lines = 0;
  int64_t loops = 0;        ///< closed in this run
  double duration_s = 0.0;  ///< of the recording
  double length_m = 0.0;    ///< of the estimated path
  /// Root mean square of the errors of position after rigid alignment, of the final and of the published path.
  std::optional<double> ate_m;
  std::optional<double> live_ate_m;
  /// What the run has shown so far; of a part of a run that comes without its path none.
  std::vector<RunWarning> warnings;
};

/// A picture of the run: the rectified left image, made smaller, and what was tracked in it, in pixels of the small
/// one (disparities: of the camera).
struct ReportPicture {
  int64_t frame_id = 0;
  int width_px = 0;
  int height_px = 0;
  std::string jpeg;
  std::string right_jpeg;  ///< of the rectified right image, smaller; empty: none
  OverlayFeatures features;
};

/// Two keyframes that see the same place; frames are -1 where the map does not have the keyframe any more.
struct ReportLoop {
  int64_t old_keyframe_id = -1;
  int64_t keyframe_id = -1;
  int64_t old_frame_id = -1;
  int64_t frame_id = -1;
  int n_points = 0;
  int n_lines = 0;
  double distance_m = 0.0;  ///< between the two cameras, and their angle
  double angle_deg = 0.0;
  double score = 0.0;
  double detect_ms = 0.0;
  double correct_ms = 0.0;
  double moved_m = 0.0;  ///< how far the correction that it caused moved a keyframe at most; 0 where nobody saw it
  std::string old_jpeg;  ///< empty: no picture
  std::string jpeg;
};

/// Keyframes before and after a correction of the map by loops: columns `keyframe`, `before`, `after`.
struct ReportCorrection {
  int64_t frame_id = -1;  ///< newest frame then
  double moved_m = 0.0;   ///< furthest move of a keyframe
  Table table;
};

/// What a process said of itself over time: columns `t_s` (since the first status of any), `frame`, `cpu_s`,
/// `memory_mb`, and one for each counter that is shown.
struct ReportProcess {
  std::string name;
  std::string state;
  std::string pace;         ///< PaceName
  double silent_s = 0.0;    ///< between its last status and the last one of any process
  double queue = 0.0;       ///< longest of its queues, at its last status
  int64_t lag_frames = -1;  ///< as ReportNode counts it; -1: it has none
  int64_t restarts = 0;     ///< how often another process of the name took over
  Table table;
};

/// Who observes the landmarks, and their ids, in the order of their tables (PackObservers).
struct ReportObservers {
  std::string points;
  std::string segments;
  bool only_ids = false;  ///< with who observes them it would be too large
};

/// The map: points (`p`, `seen`, `life`, `observations`, `sigma`), segments (`pq` instead of `p`),
/// keyframes (`id`, `frame`, `p`, `q`, `parent`, `sigma_m`), edges between rows of keyframes (`ab`, `shared`), loop
/// edges (`ab`). `seen` is the frame that saw it first, `life`
/// the number of frames from there to the last keyframe that observes it, `q` is x, y, z, w, positions are in metres in w; `sigma` is
/// the standard deviation of the position (of segments: across them, at the ends), packed (PackSigma).
struct ReportMap {
  Table points;
  Table segments;
  Table keyframes;
  Table edges;
  Table loop_edges;
  Vertical vertical;
  ReportObservers observers;
};

/// A run, or what is new of it, as the page shows it. Rows of `frames` and `path` stand for the same frames, `path`
/// for all of them: `frames` begins at row `first_row`.
struct ReportData {
  RunFacts facts;
  /// For the next question of a live page (ReportSince).
  std::string next;
  /// Everything is here: a live page forgets what it had.
  bool whole = true;
  std::vector<std::string> stage_names;
  std::vector<std::string> map_stage_names;
  int64_t first_row = 0;
  Table frames;
  std::optional<Table> path;
  std::optional<ReportMap> map;
  Table map_times;
  std::vector<ReportLoop> loops;
  std::vector<ReportCorrection> corrections;
  std::vector<ReportProcess> processes;
  std::vector<ReportPicture> pictures;
  /// What was left out, one sentence each.
  std::vector<std::string> notes;
};

}  // namespace plslam::viewer
