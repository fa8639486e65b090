// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/map.h"

namespace plslam {

/// Sums of an adjustment, for reports: root mean squares of the residuals in standard deviations and, of points,
/// pixels.
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

/// What became of a loop that loop_process told, which is named by what its `LoopClosure` says of keyframe and map.
struct LoopAnswer {
  int64_t session = 0;
  int64_t session_keyframe_id = -1;  ///< -1: no loop has been answered yet
  int64_t map_version = 0;
  bool accepted = false;

  bool operator==(const LoopAnswer&) const = default;
};

/// Whether it is the answer to that loop.
inline bool IsAnswerTo(const LoopAnswer& answer, const LoopClosure& loop) {
  return answer.session == loop.session && answer.session_keyframe_id == loop.session_keyframe_id &&
         answer.map_version == loop.map_version;
}

/// What changed in the map from one version to the next; the content of `map_update_t`. Landmarks and keyframes that
/// changed come whole, but for those that a correction has only moved: of these there are the keyframes' poses.
struct MapUpdate {
  int64_t source = 0;  ///< publisher: the start of mapping_process whose map it is; set by the receiver
  int64_t version = 0;
  /// The version it builds on. 0: on nothing, it is the whole map.
  int64_t base_version = 0;
  /// `Map::camera`.
  std::optional<StereoCamera> camera;
  /// The newest keyframe of vo_process that is in it.
  int64_t session = 0;
  int64_t session_keyframe_id = -1;
  int64_t t_ns = 0;
  /// loop_process has said all it has to say about that keyframe, and it is in the map; or there is no loop_process.
  bool committed = false;
  /// To the newest loop that was told. Every update says it again, so that nobody misses it.
  LoopAnswer answer;
  /// The map stays as it is, whatever trackers send.
  bool localise_only = false;
  /// The version with which this map took the place of another one; 0: it is the first. Said again like that.
  int64_t began_version = 0;
  /// Applied to the map of the base version, before all else (`Map::Move`).
  std::vector<MovedKeyframe> moved_keyframes;
  std::vector<MapKeyframe> keyframes;
  std::vector<int64_t> removed_keyframes;
  std::vector<MapPoint> points;
  std::vector<int64_t> removed_points;
  std::vector<MapLine> lines;
  std::vector<int64_t> removed_lines;
  /// Loops closed since.
  std::vector<LoopEdge> loops;
  /// Of the map as it then is.
  MapTotals totals;
  AdjustmentFigures adjustment;
  /// Times of the stages that led to it, ms.
  std::vector<std::pair<std::string, double>> stage_ms;
};

/// The part of `map` that `changes` names.
MapUpdate ChangedPart(const Map& map, const MapChanges& changes);
/// All of it, with base version 0.
MapUpdate WholeMap(const Map& map);

/// About which keyframes nothing more is to come. Several robots may share the map: an update names the newest
/// keyframe of one, and a committed one is about all that the map then has.
class CommittedKeyframes {
 public:
  /// The head of an update is enough.
  void Add(const MapUpdate& update);
  bool Has(int64_t session, int64_t session_keyframe_id) const;

 private:
  std::map<int64_t, int64_t> newest_;  // by session
  std::map<int64_t, int64_t> committed_;
};

/// Whose map, and how much of it, somebody has who follows its updates.
class MapVersion {
 public:
  /// kNext: the update goes on from here, and this is now that version. kKnown: it was already. kGap: versions are
  /// missing, ask for the whole map.
  enum class Step { kNext, kKnown, kGap };

  /// An update of another source counts only where it is a whole map.
  Step Advance(const MapUpdate& update);

  int64_t source() const { return source_; }
  /// 0: nothing has come.
  int64_t number() const { return number_; }

 private:
  int64_t source_ = 0;
  int64_t number_ = 0;
};

/// Keeps up with a map that somebody else owns.
class MapReplica {
 public:
  /// A whole map takes the place of this one.
  MapVersion::Step Apply(const MapUpdate& update);

  const Map& map() const { return map_; }
  int64_t source() const { return version_.source(); }
  int64_t version() const { return version_.number(); }

 private:
  void Move(const std::vector<MovedKeyframe>& keyframes);

  Map map_;
  MapVersion version_;
};

}  // namespace plslam
