// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/io/maps/map_file.h"
#include "core/map/keyframe.h"
#include "core/map/landmark_types.h"
#include "core/map/loop_closure.h"
#include "core/map/map_update.h"
#include "core/run/tracking_state.h"
#include "mapping_process/insertion/culling.h"
#include "mapping_process/insertion/inertial_links.h"
#include "mapping_process/insertion/landmark_creation.h"
#include "mapping_process/insertion/local_window.h"
#include "mapping_process/insertion/missed_landmarks.h"
#include "mapping_process/insertion/tracker_landmarks.h"
#include "mapping_process/mapper_state.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Owner of the map (PL-SLAM §V): inserts keyframes, adjusts the map around the newest, and returns the changes. No
/// clock, no messages, and no threads except within a call: the same calls give the same map.
///
/// For each keyframe: `Insert`, then `Adjust` and `Cull` once for one or several insertions, then `TakeUpdate`.
class Mapper {
 public:
  /// Expects all keyframes expressed in `camera` (`KeyframeInCamera`).
  Mapper(const StereoCamera& camera, const MappingOptions& options) : options_(options) { SetCamera(camera); }
  /// Continues a stored map with keyframes of new sessions (the caller compares its `rig`).
  Mapper(const StereoCamera& camera, const MappingOptions& options, StoredMap stored);
  /// Continues exactly from the state of another mapper: the same calls give the same bits.
  Mapper(const StereoCamera& camera, const MappingOptions& options, MapperState state);

  /// Inserts a keyframe: pose from the landmarks that it observes, observations, new landmarks, duplicates (§V.A).
  /// Keyframes of one session come in order; repeated ones are ignored. A new session is joined to an existing map if
  /// its first keyframe observes landmarks that the tracker received from the map, or is recognised among the newest
  /// keyframes. Otherwise it begins at the pose of the newest one, unconnected (no parent, no predecessor).
  ///
  /// If the map's landmarks contradict the motion since the previous keyframe (the tracker was lost and has recovered),
  /// the pose from the landmarks is taken. If that connects two parts of the map that were not connected, the younger
  /// one is moved to fit.
  ///
  /// Returns false if the keyframe was ignored; `reason` receives why.
  bool Insert(const Keyframe& keyframe, std::string* reason);

  /// Runs local bundle adjustment around the newest keyframe (§V.B).
  void Adjust(const std::atomic<bool>* stop);

  /// Removes landmarks that fail recent-landmark culling, redundant keyframes, and keyframes above
  /// `MappingOptions::max_keyframes`.
  void Cull();

  /// Applies a correction (§VI.B): listed keyframes take its poses, newer ones and landmarks move with them. For a
  /// loop, adds its edges, fuses the pairs of landmarks, searches for more, and adjusts the map around it. After a
  /// global bundle adjustment, adjusts the landmarks whose reprojection error has grown. kNone does nothing. Returns
  /// false and does nothing if the correction cannot be one of this map; `reason` receives why.
  bool Correct(const LoopClosure& closure, std::string* reason);

  /// Prepares `next`, the state of another map that replaces this one: its versions continue, so that readers know the
  /// newer map and corrections of this map are refused, and no id of this map is assigned again.
  void Precede(MapperState& next) const;

  /// Whether keyframes of the session have been inserted.
  bool HasSession(SessionId session) const { return sessions_.contains(session); }

  /// Which map it is, if it begins.
  void SetMapId(const MapId& map) { version_.map = map; }
  /// The process that assigns the ids from now on.
  void SetNumbering(SourceId numbering) { version_.numbering = numbering; }

  /// Localisation-only mode: `Insert` and `Correct` refuse everything, the map does not change.
  void SetLocaliseOnly(bool localise_only) { options_.localise_only = localise_only; }
  bool localise_only() const { return options_.localise_only; }

  /// Marks the newest keyframe as final; updates carry that until the next `Insert`.
  void Commit() { committed_ = true; }

  /// Returns the changes since the last update; `version` counts up from 1.
  MapUpdate TakeUpdate();
  /// Returns the complete map at the version of the last update.
  MapUpdate Whole() const;

  /// Returns everything needed to continue with new sessions, except `rig`. Ends recent-landmark culling here, too, so
  /// that this mapper and one that continues the stored map treat new sessions alike.
  StoredMap Store();
  /// As `Store`, without a copy of the map: `use` borrows it. If it throws, nothing has changed.
  void LendStored(const std::function<void(StoredMap&)>& use);
  /// Returns the state as of the last update, except `stored.rig`, for a mapper that continues after a crash.
  MapperState State() const;
  /// As `State`, without a copy of the map: `use` borrows it, and may throw.
  void LendState(const std::function<void(MapperState&)>& use);

  /// Moves features of keyframes that are not among the newest to a file (`plslam::MoveOldToFiles`).
  bool MoveOldToFiles() { return plslam::MoveOldToFiles(features_); }

  const StereoCamera& camera() const { return camera_; }
  /// Only for a map without keyframes.
  void SetCamera(const StereoCamera& camera) {
    camera_ = camera;
    map_.SetCamera(camera);
  }
  const Map& map() const { return map_; }
  const KeyframeFeatures& features() const { return features_; }
  int64_t version() const { return version_.number; }
  const MapId& map_id() const { return version_.map; }
  const AdjustmentFigures& figures() const { return figures_; }

  /// Adjustments that failed although there were landmarks to adjust; these did not move.
  struct Failures {
    int64_t count = 0;
    std::string last;  ///< reason of the last failure
  };
  const Failures& failures() const { return failures_; }

 private:
  /// State of the first keyframe after the tracker was lost.
  static constexpr int kRecovered = static_cast<int>(TrackingState::kRecovered);

  struct Session {
    KeyframeId keyframe_id = -1;       ///< newest, in the map; -1: removed
    int64_t session_keyframe_id = -1;  ///< its number within the session
  };

  StoredMap Stored() const;
  MapKeyframe Prepare(const Keyframe& keyframe) const;
  void Recognise(const Keyframe& keyframe, MapKeyframe& entry, Association& association) const;
  /// Returns the covariance of the pose given the landmarks.
  Matrix6d Join(const Keyframe& keyframe, MapKeyframe& entry, Association& association);
  /// Returns that covariance, too; nullopt if the landmarks do not determine the pose.
  std::optional<Matrix6d> Refine(const Keyframe& keyframe, MapKeyframe& entry, Association& association) const;
  void Place(const Keyframe& keyframe, MapKeyframe& entry, Association& association);
  bool Relocate(const Keyframe& keyframe, const Association& from_tracker, MapKeyframe& entry,
                Association& association);
  void MergeWithMap(const Keyframe& keyframe, Association& association, MapKeyframe& entry);
  void Withdraw(const Keyframe& keyframe);
  void Put(const Keyframe& keyframe, const MapKeyframe& entry, const Association& association);
  BundleResult Adjusted(const MapBundle& window, const std::atomic<bool>* stop);
  void AdjustAround(KeyframeId keyframe_id, const std::atomic<bool>* stop);
  void CloseLoop(const LoopClosure& closure);
  bool IsAmongNewest(const MapKeyframe& keyframe) const;
  void Forget();
  void Sign(MapUpdate& update) const;

  StereoCamera camera_;
  MappingOptions options_;
  Map map_;
  KeyframeFeatures features_;
  TrackerLandmarks tracker_;
  RecentLandmarks recent_landmarks_;
  MissedLandmarks missed_landmarks_;
  Visits visits_;
  InertialLinks inertial_links_;
  LandmarkIds landmark_ids_;
  KeyframeId next_keyframe_id_ = 0;
  std::map<SessionId, Session> sessions_;
  SessionId newest_session_;
  int64_t newest_t_ns_ = 0;
  MapVersion version_;
  /// The version in which the map last applied a loop or joined two parts.
  int64_t structural_version_ = 0;
  bool committed_ = false;
  AdjustmentFigures figures_;
  Failures failures_;
};

}  // namespace plslam::mapping
