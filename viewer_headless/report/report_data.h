// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/map/vertical.h"
#include "core/run/run_counters.h"
#include "core/run/run_warnings.h"
#include "viewer_headless/overlay.h"
#include "viewer_headless/report/table.h"

namespace plslam::viewer {

/// Facts in the head of the report.
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
  std::optional<ImuFigures> imu;
  /// Warnings about the run so far; empty in a partial update without the path.
  std::vector<RunWarning> warnings;
};

/// A picture of the run: the rectified left image, reduced, and its tracked features, in pixels of the reduced image
/// (disparities: of the camera).
struct ReportPicture {
  FrameId frame_id = 0;
  int width_px = 0;
  int height_px = 0;
  std::string jpeg;
  std::string right_jpeg;  ///< of the rectified right image, smaller; empty: none
  OverlayFeatures features;
};

/// Two keyframes at the same place; frames are -1 if the keyframe is not in the map any more.
struct ReportLoop {
  KeyframeId old_keyframe_id = -1;
  KeyframeId keyframe_id = -1;
  FrameId old_frame_id = -1;
  FrameId frame_id = -1;
  int n_points = 0;
  int n_lines = 0;
  double distance_m = 0.0;  ///< between the two cameras, and their angle
  double angle_deg = 0.0;
  double score = 0.0;
  double detect_ms = 0.0;
  double correct_ms = 0.0;
  double moved_m = 0.0;  ///< largest move of a keyframe by the correction that it caused; 0 if it was not observed
  std::string old_jpeg;  ///< empty: no picture
  std::string jpeg;
};

/// Keyframes before and after a correction of the map by loops: columns `keyframe`, `before`, `after`.
struct ReportCorrection {
  FrameId frame_id = -1;  ///< newest frame at that time
  double moved_m = 0.0;   ///< furthest move of a keyframe
  Table table;
};

/// Statistics of a process over time: columns `t_s` (since the first status of any process), `uptime_s` (by its own
/// clock), `frame`, `cpu_s`, `memory_mb`, and one for each displayed counter.
struct ReportProcess {
  std::string name;
  std::string state;
  std::string pace;         ///< PaceName
  double silent_s = 0.0;    ///< between its last status and the last one of any process
  double queue = 0.0;       ///< length of its longest queue, at its last status
  int64_t lag_frames = -1;  ///< as ReportNode counts it; -1: it has none
  int64_t restarts = 0;     ///< how often another process of the name took over
  Table table;
};

/// The observing keyframes of landmarks, and the landmarks' ids, in the order of their tables (PackObservers).
struct ReportObservers {
  std::string points;
  std::string segments;
  bool only_ids = false;  ///< with the observing keyframes it would be too large
};

/// The map: points (`p`, `seen`, `life`, `observations`, `sigma`), segments (`pq` instead of `p`), keyframes (`id`,
/// `frame`, `p`, `q`, `parent`, `sigma_m`), edges between rows of keyframes (`ab`, `shared`), loop edges (`ab`). `seen`
/// is the frame that saw it first, `life` the number of frames from there to the last keyframe that observes it, `q` is
/// x, y, z, w, positions are in metres in w; `sigma` is the standard deviation of the position (of segments: across
/// them, at the ends), packed (PackSigma).
struct ReportMap {
  Table points;
  Table segments;
  Table keyframes;
  Table edges;
  Table loop_edges;
  Vertical vertical;
  ReportObservers observers;
};

/// The occupancy grid as a picture: grey values of map.pgm, its first row the one with the largest y.
struct ReportGrid {
  std::string png;
  double pixel_m = 0.0;
  int width_px = 0;
  int height_px = 0;
  Eigen::Vector3d corner_level = Eigen::Vector3d::Zero();  ///< lower left corner, on the floor, in the level frame
  SE3 T_w_level;
};

/// Surface points (`p`, in steps from `low_w`; `normal`, 128 + 127 times the unit length; `grey`), and the grid.
struct ReportSurfaces {
  Table points;
  Eigen::Vector3d low_w = Eigen::Vector3d::Zero();
  double step_m = 1.0;
  double spacing_m = 0.0;  ///< distance of neighbouring points
  std::optional<ReportGrid> grid;
};

/// A run, or the new data of it, for the page. Rows of `frames` and `path` refer to the same frames, `path` to all of
/// them: `frames` begins at row `first_row`.
struct ReportData {
  RunFacts facts;
  /// For the next request of a live page (ReportSince).
  std::string next;
  /// All data are included: a live page drops its previous data.
  bool whole = true;
  std::vector<std::string> stage_names;
  std::vector<std::string> map_stage_names;
  int64_t first_row = 0;
  Table frames;
  std::optional<Table> path;
  std::optional<ReportMap> map;
  std::optional<ReportSurfaces> surfaces;
  Table map_times;
  std::vector<ReportLoop> loops;
  std::vector<ReportCorrection> corrections;
  std::vector<ReportProcess> processes;
  std::vector<ReportPicture> pictures;
  /// One sentence for each omission.
  std::vector<std::string> notes;
};

}  // namespace plslam::viewer
