// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/ids/map_version.h"
#include "core/map/map.h"

namespace plslam {

/// Statistics of an adjustment, for reports: root mean squares of the residuals, in standard deviations and, for
/// points, in pixels.
struct AdjustmentFigures {
  int n_keyframes = 0;
  int n_fixed_keyframes = 0;
  int n_points = 0;
  int n_lines = 0;
  int n_outliers = 0;
  double rms_before = 0.0;
  double rms_after = 0.0;
  double reprojection_before_px = 0.0;
  double reprojection_after_px = 0.0;
};

/// Decision about a loop of loop_process, identified by keyframe and map version as in its `LoopClosure`.
struct LoopAnswer {
  KeyframeName keyframe;  ///< without a number: no loop was decided yet
  std::optional<MapVersion> map_version;
  bool accepted = false;

  bool operator==(const LoopAnswer&) const = default;
};

/// Whether it answers that loop. A map that was rebuilt in lockstep has the same numbers of versions under another
/// numbering, and so has a loop that is detected again in it.
inline bool IsAnswerTo(const LoopAnswer& answer, const LoopClosure& loop) {
  if (answer.keyframe != loop.keyframe || answer.map_version.has_value() != loop.map_version.has_value())
    return false;
  return !loop.map_version || (answer.map_version->map.Matches(loop.map_version->map) &&
                               answer.map_version->number == loop.map_version->number);
}

/// Changes of the map from one version to the next; the content of `map_update_t`. Changed landmarks and keyframes are
/// complete; for those that a correction has only moved there are the keyframes' poses.
struct MapUpdate {
  SourceId source;  ///< publisher: the run of mapping_process that owns the map; set by the receiver
  int64_t version = 0;
  /// The version to which it applies; nullopt: this is the complete map.
  std::optional<int64_t> base_version;
  /// `Map::camera`.
  std::optional<StereoCamera> camera;
  /// The newest keyframe of vo_process in it, and its time.
  KeyframeName newest;
  int64_t t_ns = 0;
  /// Whether the newest keyframe is final: all closures about it are applied, or there is no loop_process.
  bool committed = false;
  /// To the newest published loop. Repeated in each update, so that none is missed.
  LoopAnswer answer;
  /// Localisation-only mode: the map does not change.
  bool localise_only = false;
  /// Repeated in each update.
  MapId map_id;
  /// Applied to the map of the base version before all other changes (`Map::Move`).
  std::vector<MovedKeyframe> moved_keyframes;
  std::vector<MapKeyframe> keyframes;
  std::vector<KeyframeId> removed_keyframes;
  std::vector<MapPoint> points;
  std::vector<LandmarkId> removed_points;
  std::vector<MapLine> lines;
  std::vector<LandmarkId> removed_lines;
  /// Loops closed since the base version, and those that a removed keyframe has passed on to another one. The loops of
  /// removed keyframes are removed with them.
  std::vector<LoopEdge> loops;
  /// Totals of the resulting map.
  MapTotals totals;
  AdjustmentFigures adjustment;
  /// Durations of the stages that led to it, in ms.
  std::vector<std::pair<std::string, double>> stage_ms;

  MapVersion Version() const { return {map_id, source, version}; }
  bool IsWhole() const { return !base_version; }
  /// Makes it the update after version `number`; the first one, after 0, is the complete map.
  void Follow(int64_t number) {
    if (number > 0) base_version = number;
    version = number + 1;
  }
};

/// Returns the part of `map` that `changes` lists.
MapUpdate ChangedPart(const Map& map, const MapChanges& changes);
/// Returns the complete map, without a base version.
MapUpdate WholeMap(const Map& map);

}  // namespace plslam
