// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/report_recorder.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/accuracy/roll.h"
#include "core/run/final_trajectory.h"
#include "core/run/machine.h"
#include "plslam_version.h"
#include "viewer_headless/report/map_tables.h"
#include "viewer_headless/report/surface_tables.h"

namespace plslam::viewer {
namespace {

/// Returns the ordinal of a power of two: "2nd", "4th".
std::string Ordinal(int64_t n) { return fmt::format("{}{}", n, n % 10 == 2 && n % 100 != 12 ? "nd" : "th"); }

}  // namespace

void ReportRecorder::Begin(const RunHead& head) {
  head_ = head;
  pictures_.Announce(head.announced_frames);
}

void ReportRecorder::Add(const MapUpdate& update, const Map& map, FrameId frame_id) {
  ++n_map_updates_;
  corrections_.Add(update, map, frame_id);
  map_times_.Add(update, frame_id);
}

void ReportRecorder::Finish() {
  finished_ = true;
  // Makes a live page request the final state of everything.
  ++n_map_updates_;
}

RunFacts ReportRecorder::Facts(const Recorder& recorder, const Map& map) const {
  RunFacts facts;
  facts.dataset = head_.dataset;
  facts.pace = head_.pace;
  facts.version = PLSLAM_VERSION;
  facts.announced_frames = head_.announced_frames;
  facts.camera = camera_;
  facts.frames = recorder.Tally(finished_);
  const MapTotals totals = map.Totals();
  facts.keyframes = totals.keyframes > 0 ? totals.keyframes : recorder.keyframes();
  facts.points = totals.points;
  facts.lines = totals.lines;
  facts.loops = loops_.closed();
  facts.imu = ImuFiguresOf(counters_);
  if (recorder.frames().empty()) return facts;
  const int64_t t_ns = recorder.frames().Last().second.t_ns - recorder.frames().First().second.t_ns;
  for (const auto& [frame_id, frame] : recorder.frames()) {
    const FrameCounts& n = frame.counts;
    facts.moving.Add(FrameId(frame_id), n.moving, n.points + n.lines, n.bodies);
  }
  facts.duration_s = 1e-9 * static_cast<double>(t_ns);
  return facts;
}

std::vector<RunWarning> ReportRecorder::Warnings(const RunFacts& facts, const PathOfRun& path) const {
  RunFindings findings;
  findings.dataset = head_.dataset;
  findings.frames = facts.frames;
  findings.Take(counters_);
  findings.published = warnings_.all();
  findings.ate_m = path.ate_m;
  findings.true_spread_m = path.true_spread_m;
  findings.nees_pose = path.consistency.mean_nees;
  findings.nees_poses = path.consistency.n;
  return WarningsOf(findings);
}

void ReportRecorder::AddPictures(int64_t after, ReportData* data) const {
  for (auto at = pictures_.pictures().upper_bound(FrameId(after)); at != pictures_.pictures().end(); ++at) {
    data->pictures.push_back(at->second);
  }
}

void ReportRecorder::AddNotes(const Recorder& recorder, const Map& map, int64_t stride, ReportData* data) const {
  data->notes.push_back(fmt::format("Times were measured on {}.", MachineText()));
  if (stride > 1)
    data->notes.push_back(fmt::format("Every {} of {} frames is shown.", Ordinal(stride), recorder.frames().size()));
  if (pictures_.stride() > 1) {
    data->notes.push_back(fmt::format("Every {} frame has a picture.", Ordinal(pictures_.stride())));
  }
  if (pictures_.missing() > 0) {
    data->notes.push_back(
        fmt::format("{} of {} pictures of frames are missing: their images or features were not received.",
                    pictures_.missing(), pictures_.missing() + static_cast<int64_t>(pictures_.pictures().size())));
  }
  if (surfaces_.cloud != nullptr && surfaces_.cloud->n_points() > SurfaceLimits().points) {
    data->notes.push_back(fmt::format("The surfaces are drawn with at most {} of their {} points.",
                                      SurfaceLimits().points, surfaces_.cloud->n_points()));
  }
  if (corrections_.dropped() > 0) {
    data->notes.push_back(fmt::format("{} smaller corrections by loops are not shown.", corrections_.dropped()));
  }
  if (map.loops().size() > kMaxLoopPictures) {
    data->notes.push_back(fmt::format("Only the newest {} loops have pictures.", kMaxLoopPictures));
  }
}

ReportData ReportRecorder::Build(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c,
                                 const ReportSince& since) const {
  const int64_t stride = FrameStride(recorder);
  ReportData data;
  data.whole = since.run != run_ || since.stride != stride;
  const ReportSince from = data.whole ? ReportSince() : since;
  data.facts = Facts(recorder, map);
  data.facts.finished = finished_;
  data.stage_names = recorder.stage_names();
  data.first_row = from.rows;
  data.frames = FrameTable(recorder, stride, from.rows);
  AddPictures(from.picture, &data);
  const int64_t rows = from.rows + static_cast<int64_t>(Rows(data.frames));
  const int64_t picture = data.pictures.empty() ? from.picture : data.pictures.back().frame_id.value;
  data.next = ReportSince{run_, stride, rows, n_map_updates_, picture, n_surface_changes_}.Text();
  if (n_surface_changes_ > 0 && from.surfaces != n_surface_changes_) {
    data.surfaces = SurfaceTables(*surfaces_.cloud, surfaces_.grid(), {});
  }
  AddNotes(recorder, map, stride, &data);
  data.processes = processes_.Processes();
  // Without a map there is no event when the path changes.
  if (n_map_updates_ > 0 && from.map_version == n_map_updates_) return data;
  PathOfRun path = PathTable(recorder, map, q_l_c, stride);
  data.facts.ate_m = path.ate_m;
  data.facts.live_ate_m = path.live_ate_m;
  data.facts.length_m = path.length_m;
  data.facts.warnings = Warnings(data.facts, path);
  data.path = std::move(path.table);
  if (path.roll_sigma_deg) {
    data.notes.push_back(
        fmt::format("Orientations are aligned by their own mean: of the roll, {}.", RollText(*path.roll_sigma_deg)));
  }
  const RunParts parts(map, recorder);
  if (parts.size() > 1) {
    data.notes.push_back(fmt::format(
        "{} unconnected parts of the map are not shown: their place is unknown. Their files are in part2 ...",
        parts.size() - 1));
  }
  data.map = MapTables(parts.MapOf(0), {}, &data.notes);
  data.map_stage_names = map_times_.stage_names();
  data.map_times = map_times_.Times();
  data.loops = loops_.Loops(map, corrections_, pictures_);
  data.corrections = corrections_.corrections();
  return data;
}

}  // namespace plslam::viewer
