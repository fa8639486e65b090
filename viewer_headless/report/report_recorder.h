// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/ids/ids.h"
#include "core/map/map_update.h"
#include "core/map/occupancy_grid.h"
#include "core/map/surface_cloud.h"
#include "core/run/published_warnings.h"
#include "core/run/recorder.h"
#include "viewer_headless/report/frame_tables.h"
#include "viewer_headless/report/loop_log.h"
#include "viewer_headless/report/map_times.h"
#include "viewer_headless/report/picture_store.h"
#include "viewer_headless/report/process_log.h"
#include "viewer_headless/report/report_data.h"
#include "viewer_headless/report/report_json.h"

namespace plslam::viewer {

/// Description of the run: dataset, pace, number of frames.
struct RunHead {
  std::string dataset;
  std::string pace;
  int64_t announced_frames = -1;
};

/// The surfaces of a run, which change during it.
struct SurfaceSource {
  const SurfaceCloud* cloud = nullptr;  ///< nullptr: none
  std::function<OccupancyGrid()> grid;
};

/// Collects the data of a report beside the poses and the map, in bounded memory, during a run.
class ReportRecorder {
 public:
  /// Stores at most `max_pictures` pictures of frames; `run` counts the streams.
  explicit ReportRecorder(int64_t max_pictures, int64_t run = 0) : pictures_(max_pictures), run_(run) {}

  void Begin(const RunHead& head);
  void SetCamera(const StereoCamera& camera) { camera_ = camera; }
  void SetSurfaces(SurfaceSource surfaces) { surfaces_ = std::move(surfaces); }
  void SurfacesChanged() { ++n_surface_changes_; }
  void Add(const ProcessSample& sample) { processes_.Add(sample); }
  /// A counter of the status of a process.
  void Take(SourceId source, const std::string& name, double value) { counters_.Take(source, name, value); }
  void AddWarning(const std::string& code, const std::string& sentence) { warnings_.Add(code, sentence); }
  void Add(const LoopClosure& closure) { loops_.Add(closure); }
  /// Called after `update` was applied to `map`; `frame_id` is the newest frame.
  void Add(const MapUpdate& update, const Map& map, FrameId frame_id);
  /// Marks the run as ended.
  void Finish();
  PictureStore& pictures() { return pictures_; }
  const PictureStore& pictures() const { return pictures_; }

  /// Returns the data that a page with `since` does not have yet.
  ReportData Build(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c,
                   const ReportSince& since) const;

 private:
  std::vector<RunWarning> Warnings(const RunFacts& facts, const PathOfRun& path) const;
  RunFacts Facts(const Recorder& recorder, const Map& map) const;
  void AddPictures(int64_t after, ReportData* data) const;
  void AddNotes(const Recorder& recorder, const Map& map, int64_t stride, ReportData* data) const;

  RunHead head_;
  std::optional<StereoCamera> camera_;
  PictureStore pictures_;
  ProcessLog processes_;
  RunCounters counters_;
  PublishedWarnings warnings_;
  CorrectionLog corrections_;
  LoopLog loops_;
  MapTimes map_times_;
  SurfaceSource surfaces_;
  int64_t n_surface_changes_ = 0;
  int64_t run_;
  int64_t n_map_updates_ = 0;
  bool finished_ = false;
};

}  // namespace plslam::viewer
