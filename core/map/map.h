// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/id_map.h"
#include "core/map/keyframe.h"
#include "core/map/landmarks.h"
#include "core/map/loop_closure.h"
#include "core/map/removed_poses.h"

namespace plslam {

/// Numbers of landmarks shared with other keyframes: a row of the covisibility graph. Contiguous in memory, because an
/// observation changes many rows.
class SharedCounts {
 public:
  /// The other keyframe and the count (>= 1), ascending by keyframe.
  using Count = std::pair<KeyframeId, int>;

  void Add(KeyframeId keyframe_id, int n) {
    const auto place = Place(counts_, keyframe_id);
    if (place == counts_.end() || place->first != keyframe_id) {
      counts_.insert(place, {keyframe_id, n});
    } else if ((place->second += n) == 0) {
      counts_.erase(place);
    }
  }

  int Of(KeyframeId keyframe_id) const {
    const auto place = Place(counts_, keyframe_id);
    return place == counts_.end() || place->first != keyframe_id ? 0 : place->second;
  }

  std::vector<Count>::const_iterator begin() const { return counts_.begin(); }
  std::vector<Count>::const_iterator end() const { return counts_.end(); }

 private:
  /// Returns the position of the keyframe's count, or the position at which to insert it.
  template <class Counts>
  static auto Place(Counts& counts, KeyframeId keyframe_id) -> decltype(counts.begin()) {
    return std::lower_bound(counts.begin(), counts.end(), keyframe_id,
                            [](const Count& count, KeyframeId id) { return count.first < id; });
  }

  std::vector<Count> counts_;
};

/// A keyframe moved by a correction, together with its landmarks (`Map::Move`).
struct MovedKeyframe {
  KeyframeId id = -1;
  SE3 T_w_kf;
  Matrix6d covariance = Matrix6d::Zero();
};

/// Ids of what has changed since the last `Map::TakeChanges`, ascending; removed ids are listed only as removed.
/// Landmarks that only moved with a keyframe are not listed.
struct MapChanges {
  /// Applied before all other changes.
  std::vector<MovedKeyframe> moved_keyframes;
  std::vector<KeyframeId> keyframes, removed_keyframes;
  std::vector<LandmarkId> points, removed_points;
  std::vector<LandmarkId> lines, removed_lines;
  std::vector<LoopEdge> loops;

  bool empty() const;
};

/// Numbers of elements in a map.
struct MapTotals {
  int64_t keyframes = 0;
  int64_t points = 0;
  int64_t lines = 0;
  int64_t point_observations = 0;
  int64_t line_observations = 0;
  int64_t loops = 0;

  bool operator==(const MapTotals&) const = default;
};

/// Keyframes, landmarks of both feature types and their connections (PL-SLAM §V): covisibility graph, essential graph
/// and spanning tree. A value; everything is ordered by id. The graphs follow from the observations of the landmarks,
/// so maps with the same keyframes and landmarks have the same graphs.
///
/// Ignores observations of keyframes that are not in the map. Throws std::invalid_argument for observations that do not
/// ascend, or of negative features. Covariances of landmarks are in single precision, as in messages, so a copy that
/// has followed all updates equals one that was received whole, bit for bit.
class Map {
 public:
  /// Least number of shared landmarks for an edge of the covisibility graph, and of the essential graph.
  static constexpr int kCovisible = 20;
  static constexpr int kEssential = 100;
  /// Least number of landmarks shared with a parent in the spanning tree other than the previous keyframe.
  static constexpr int kParent = 15;

  struct Neighbour {
    KeyframeId keyframe_id = -1;
    int shared = 0;

    bool operator==(const Neighbour&) const = default;
  };

  /// Landmark of each feature of a keyframe, or -1; also -1 for features beyond the end of the vectors.
  struct FeatureLandmarks {
    std::vector<LandmarkId> points;
    std::vector<LandmarkId> lines;
  };

  /// The rectified camera in which the features of all keyframes are expressed; nullopt if unknown.
  const std::optional<StereoCamera>& camera() const { return camera_; }
  void SetCamera(const StereoCamera& camera) { camera_ = camera; }

  const IdMap<KeyframeId, MapKeyframe>& keyframes() const { return keyframes_; }
  const IdMap<LandmarkId, MapPoint>& points() const { return points_; }
  const IdMap<LandmarkId, MapLine>& lines() const { return lines_; }
  /// Return nullptr if there is none.
  const MapKeyframe* FindKeyframe(KeyframeId id) const;
  const MapPoint* FindPoint(LandmarkId id) const;
  const MapLine* FindLine(LandmarkId id) const;
  MapTotals Totals() const;
  /// Closed loops, ascending by `keyframe_id`, the later of two at the same one last. Their keyframes are in the map.
  const std::vector<LoopEdge>& loops() const { return loops_; }

  /// Insert, or replace the element with the same id. If a feature is an observation of another landmark, that landmark
  /// loses it.
  void Put(const MapKeyframe& keyframe);
  void Put(const MapPoint& point);
  void Put(const MapLine& line);
  /// Removes a keyframe, its observations and loops, and landmarks that lose their last observation. Its children in the
  /// spanning tree move to their best neighbour (`kParent`), or to its parent if they have none.
  void RemoveKeyframe(KeyframeId id);
  void RemovePoint(LandmarkId id);
  void RemoveLine(LandmarkId id);
  /// From now on keeps the poses of keyframes that are removed, for final trajectories (`RemovedPoses`). The carrier of
  /// each is the oldest keyframe with which it shared at least half as many landmarks as with any (without one: its
  /// parent, its predecessor, or the nearest keyframe).
  void RememberRemoved() {
    if (!removed_) removed_.emplace();
  }
  /// Returns the remembered keyframes, ascending by id.
  std::vector<RemovedKeyframe> RemovedKeyframes() const;
  /// Remembers these removed keyframes no longer.
  void ForgetRemoved(const std::set<KeyframeId>& ids) {
    if (removed_) removed_->Forget(ids);
  }
  /// The following changes of remembered keyframes belong to this version.
  void BeginVersion(int64_t version);
  /// Ignores a loop with a keyframe that is not in the map.
  void Add(const LoopEdge& loop);
  void Clear();
  /// Replaces this map by `next`, the same map in the state of `version`, and keeps the remembered keyframes. A keyframe
  /// in both maps whose pose differs in a later version counts as corrected.
  void ContinueAs(Map next, int64_t version);

  /// Move an element without changing observations.
  void SetPose(KeyframeId keyframe_id, const SE3& T_w_kf, const Matrix6d& covariance);
  void SetPosition(LandmarkId point_id, const Eigen::Vector3d& p_w, const Eigen::Matrix3d& covariance);
  void SetSegment(LandmarkId line_id, const Segment3& segment_w, const Eigen::Matrix3d& covariance_p,
                  const Eigen::Matrix3d& covariance_q);

  /// Applies a correction: moves keyframes, and each landmark rigidly with its anchor (`AnchorOf`), rotating
  /// covariances. Keyframes not changed otherwise since the last `TakeChanges` count as moved, so that the poses alone
  /// describe the correction of a large map. Ignores keyframes that are not in the map, or have that pose already.
  void Move(const std::map<KeyframeId, SE3>& T_w_kf);
  /// Sets covariances without moving keyframes.
  void SetCovariances(const std::map<KeyframeId, Matrix6d>& covariances);

  const FeatureLandmarks& LandmarksOf(KeyframeId keyframe_id) const;
  int Shared(KeyframeId a, KeyframeId b) const;
  /// Returns the keyframes that share at least `min_shared` (>= 1) landmarks with this one: most shared first, then by
  /// id.
  std::vector<Neighbour> Neighbours(KeyframeId keyframe_id, int min_shared) const;
  std::vector<KeyframeId> Children(KeyframeId keyframe_id) const;

  /// Returns the changes since the last call.
  MapChanges TakeChanges();
  /// For owners that do not publish changes.
  void ForgetChanges();

 private:
  /// The members of `Map` for one feature type.
  template <class Landmark>
  struct Kind {
    IdMap<LandmarkId, Landmark>& landmarks;
    std::vector<LandmarkId> FeatureLandmarks::*of;
    std::vector<LandmarkId>& touched;
    int64_t& n_observations;
  };
  /// Ids that were inserted, changed or removed, possibly repeated: those in the map have changed, the others are gone.
  struct Touched {
    std::vector<KeyframeId> keyframes;
    std::vector<LandmarkId> points, lines;
    std::vector<LoopEdge> loops;  ///< added, and not removed since
  };
  /// Working data of `Move`: displacements of the moved keyframes, and those keyframes whose landmarks must be listed
  /// individually, because they had changed before.
  struct Moves {
    std::map<KeyframeId, SE3> T_new_old;  // displacement in the map frame
    std::set<KeyframeId> changed_anchors;
  };
  Kind<MapPoint> Points();
  Kind<MapLine> Lines();

  template <class Landmark>
  void PutLandmark(const Landmark& landmark, Kind<Landmark> kind);
  template <class Landmark>
  void RemoveLandmark(LandmarkId id, Kind<Landmark> kind);
  template <class Landmark>
  void SetObservations(Landmark& landmark, std::vector<Observation> observations, Kind<Landmark> kind);
  template <class Landmark>
  void FollowObservations(const std::vector<Observation>& old, const Landmark& landmark, Kind<Landmark> kind);
  template <class Landmark>
  void DropObservationsOf(KeyframeId keyframe_id, Kind<Landmark> kind);
  void CountShared(const std::vector<Observation>& observations, const std::vector<Observation>& others, int sign);
  template <class Landmark>
  void MoveLandmarks(const Moves& moves, Kind<Landmark> kind);
  KeyframeId CarrierOf(const MapKeyframe& keyframe) const;

  std::optional<StereoCamera> camera_;
  IdMap<KeyframeId, MapKeyframe> keyframes_;
  IdMap<LandmarkId, MapPoint> points_;
  IdMap<LandmarkId, MapLine> lines_;
  IdMap<KeyframeId, FeatureLandmarks> landmarks_of_;
  IdMap<KeyframeId, SharedCounts> shared_;
  IdMap<KeyframeId, std::set<KeyframeId>> children_;
  int64_t n_point_observations_ = 0;
  int64_t n_line_observations_ = 0;
  std::vector<LoopEdge> loops_;
  Touched touched_;
  /// Poses of moved keyframes that had not changed otherwise before.
  std::map<KeyframeId, SE3> moved_;
  /// Poses of removed keyframes; nullopt: they are not remembered.
  std::optional<RemovedPoses> removed_;
};

}  // namespace plslam
