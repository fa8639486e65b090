// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "core/geometry/stereo_camera.h"
#include "core/io/maps/map_file.h"
#include "core/map/keyframe.h"
#include "core/map/landmark_types.h"
#include "core/map/loop_closure.h"
#include "core/map/map_update.h"
#include "core/run/tracking_state.h"
#include "mapping_process/insertion/culling.h"
#include "mapping_process/insertion/landmark_creation.h"
#include "mapping_process/insertion/local_window.h"
#include "mapping_process/insertion/tracker_landmarks.h"
#include "mapping_process/mapper_state.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Owner of the map (PL-SLAM §V): takes keyframes in, adjusts the map around the newest, and tells what changed. No
/// clock, no messages, and no thread but within a call: the same calls give the same map.
///
/// For each keyframe: `Insert`, then `Adjust` and `Cull` once for one or several insertions, then `TakeUpdate`.
class Mapper {
 public:
  /// All keyframes are told in `camera` (`ToldIn`).
  Mapper(const StereoCamera& camera, const MappingOptions& options) : options_(options) { SetCamera(camera); }
  /// Goes on in a map that was stored (its `rig` is the caller's to compare), with keyframes of new sessions.
  Mapper(const StereoCamera& camera, const MappingOptions& options, StoredMap stored);
  /// Goes on exactly where another one was: the same calls give the same bits from here on.
  Mapper(const StereoCamera& camera, const MappingOptions& options, MapperState state);

  /// Joins a keyframe to the map: pose among the landmarks it shows, observations, new landmarks, duplicates (§V.A).
  /// Keyframes of one session come in order; one that came before is ignored. A session that starts while there is a
  /// map is joined to it where its first keyframe shows landmarks that the map gave its tracker, or is recognised
  /// among the newest keyframes, and else begins at the place of the newest one without connection (no parent, none
  /// before).
  ///
  /// A keyframe that the map's own landmarks place elsewhere than the motion since the one before (its tracker was
  /// lost and has been found again) lies where they say. If that ties two parts of the map that nothing connected,
  /// the younger is moved to fit.
  ///
  /// False where the keyframe was ignored; `reason` says why.
  bool Insert(const Keyframe& keyframe, std::string* reason);

  /// Local bundle adjustment around the newest keyframe (§V.B).
  void Adjust(const std::atomic<bool>* stop);

  /// Takes out landmarks that did not prove themselves, redundant keyframes, and what is beyond
  /// `MappingOptions::max_keyframes`.
  void Cull();

  /// Takes a correction over (§VI.B): keyframes lie where it says, newer ones are carried along, and landmarks move
  /// with them. Of a loop, its edges become part of the map, the landmarks of both sides that are the same become
  /// one, more of these are searched, and the map is adjusted around it. After an adjustment of the whole map,
  /// landmarks that keyframes see worse than before are placed anew. kNone does nothing. False, and nothing done,
  /// where it cannot be one of this map; `reason` says why.
  bool Correct(const LoopClosure& closure, std::string* reason);

  /// Makes `next` the state of a mapper that takes the place of this one with another map. Versions go on, so readers
  /// know which is the newer, and what was computed on this map is refused. No id of this map is given again.
  void Precede(MapperState& next) const;

  /// Whether the map stays as it is: then `Insert` and `Correct` refuse everything.
  void SetLocaliseOnly(bool localise_only) { options_.localise_only = localise_only; }
  bool localise_only() const { return options_.localise_only; }

  /// Nothing more is to be said about the newest keyframe; until the next `Insert`, updates carry that.
  void Commit() { committed_ = true; }

  /// What has changed since the last one; `version` counts up from 1.
  MapUpdate TakeUpdate();
  /// All of the map at the version of the last update.
  MapUpdate Whole() const;

  /// All that is needed to go on with new sessions, but for `rig`. Recent landmarks are accepted, here too: so this
  /// mapper and one that goes on from what was stored make the same of the same new sessions.
  StoredMap Store();
  void AcceptRecentLandmarks() { recent_landmarks_ = {}; }
  /// Everything as of the last update, but for `stored.rig`, for a mapper that goes on after a crash of this one.
  MapperState State() const;
  /// The same, without a copy of the map: it is lent to `use`, which may throw, and taken back.
  void LendState(const std::function<void(MapperState&)>& use);

  /// Features of keyframes that are not among the newest leave the memory (`plslam::LeaveOldInFiles`).
  bool LeaveOldInFiles() { return plslam::LeaveOldInFiles(features_); }

  const StereoCamera& camera() const { return camera_; }
  /// For a map without keyframes.
  void SetCamera(const StereoCamera& camera) {
    camera_ = camera;
    map_.SetCamera(camera);
  }
  const Map& map() const { return map_; }
  const KeyframeFeatures& features() const { return features_; }
  int64_t version() const { return version_; }
  const AdjustmentFigures& figures() const { return figures_; }

  /// Adjustments that failed although there was something to adjust; what they should have moved stays where it was.
  struct Failures {
    int64_t count = 0;
    std::string last;  ///< why
  };
  const Failures& failures() const { return failures_; }

 private:
  /// State of a keyframe that is the first one after the tracker was lost.
  static constexpr int kRecovered = static_cast<int>(TrackingState::kRecovered);

  struct Session {
    int64_t keyframe_id = -1;          ///< newest, in the map; -1: it has been forgotten
    int64_t session_keyframe_id = -1;  ///< the same, as the session counts
  };

  StoredMap Stored() const;
  MapKeyframe Prepare(const Keyframe& keyframe) const;
  void Recognise(const Keyframe& keyframe, MapKeyframe& entry, Association& association) const;
  void Join(const Keyframe& keyframe, MapKeyframe& entry, Association& association);
  bool Refine(const Keyframe& keyframe, MapKeyframe& entry, Association& association) const;
  void Place(const Keyframe& keyframe, MapKeyframe& entry, Association& association);
  bool Relocate(const Keyframe& keyframe, const Association& from_tracker, MapKeyframe& entry,
                Association& association);
  void BringTogether(const Keyframe& keyframe, Association& association, MapKeyframe& entry);
  void Withdraw(const Keyframe& keyframe);
  void Put(const Keyframe& keyframe, const MapKeyframe& entry, const Association& association);
  BundleResult Adjusted(const MapBundle& window, const std::atomic<bool>* stop);
  void AdjustAround(int64_t keyframe_id, const std::atomic<bool>* stop);
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
  LandmarkIds landmark_ids_;
  int64_t next_keyframe_id_ = 0;
  std::map<int64_t, Session> sessions_;
  int64_t newest_session_ = 0;
  int64_t newest_t_ns_ = 0;
  int64_t version_ = 0;
  /// The first version that has the last loop in it, or the last that brought two parts together.
  int64_t structural_version_ = 0;
  int64_t began_version_ = 0;
  bool committed_ = false;
  AdjustmentFigures figures_;
  Failures failures_;
};

}  // namespace plslam::mapping
