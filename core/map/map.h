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

namespace plslam {

/// How many landmarks a keyframe shares with others: a row of the covisibility graph. In one piece of memory, as each
/// observation that comes or goes is counted in many rows.
class SharedCounts {
 public:
  /// The other keyframe and how many (>= 1), ascending by keyframe.
  using Count = std::pair<int64_t, int>;

  void Add(int64_t keyframe_id, int n) {
    const auto place = Place(counts_, keyframe_id);
    if (place == counts_.end() || place->first != keyframe_id) {
      counts_.insert(place, {keyframe_id, n});
    } else if ((place->second += n) == 0) {
      counts_.erase(place);
    }
  }

  int Of(int64_t keyframe_id) const {
    const auto place = Place(counts_, keyframe_id);
    return place == counts_.end() || place->first != keyframe_id ? 0 : place->second;
  }

  std::vector<Count>::const_iterator begin() const { return counts_.begin(); }
  std::vector<Count>::const_iterator end() const { return counts_.end(); }

 private:
  /// Where the count of the keyframe is, or would have to be.
  template <class Counts>
  static auto Place(Counts& counts, int64_t keyframe_id) -> decltype(counts.begin()) {
    return std::lower_bound(counts.begin(), counts.end(), keyframe_id,
                            [](const Count& count, int64_t id) { return count.first < id; });
  }

  std::vector<Count> counts_;
};

/// A keyframe that a correction has moved, and its landmarks with it (`Map::Move`).
struct MovedKeyframe {
  int64_t id = -1;
  SE3 T_w_kf;
  Matrix6d covariance = Matrix6d::Zero();
};

/// Names of what has changed since the last `Map::TakeChanges`, ascending; what was removed stands only among the
/// removed. Landmarks that have only gone with a moved keyframe are not named.
struct MapChanges {
  /// Applied before all else.
  std::vector<MovedKeyframe> moved_keyframes;
  std::vector<int64_t> keyframes, removed_keyframes;
  std::vector<int64_t> points, removed_points;
  std::vector<int64_t> lines, removed_lines;
  std::vector<LoopEdge> loops;

  bool empty() const;
};

/// How much is in a map.
struct MapTotals {
  int64_t keyframes = 0;
  int64_t points = 0;
  int64_t lines = 0;
  int64_t point_observations = 0;
  int64_t line_observations = 0;
  int64_t loops = 0;

  bool operator==(const MapTotals&) const = default;
};

/// Keyframes, landmarks of both feature types and what connects them (PL-SLAM §V): covisibility graph, essential
/// graph and spanning tree. Plain values with ids, ordered by id. The graphs follow from the observations of the
/// landmarks, so whoever has the same keyframes and landmarks has the same graphs.
///
/// Observations of keyframes that are not in the map are ignored. Observations that do not ascend, or of negative
/// features, are std::invalid_argument. Covariances of landmarks are kept in single precision, as messages carry
/// them: so a copy that has followed all updates and one that came whole are the same, bit for bit.
class Map {
 public:
  /// Edges of the covisibility graph and of the essential graph: landmarks that two keyframes share.
  static constexpr int kCovisible = 20;
  static constexpr int kEssential = 100;
  /// What a keyframe shares with its parent in the spanning tree, where that is not the one before it.
  static constexpr int kParent = 15;

  struct Neighbour {
    int64_t keyframe_id = -1;
    int shared = 0;

    bool operator==(const Neighbour&) const = default;
  };

  /// The landmark that each feature of a keyframe belongs to, or -1; features beyond the end of the vectors have
  /// none.
  struct FeatureLandmarks {
    std::vector<int64_t> points;
    std::vector<int64_t> lines;
  };

  /// The rectified camera that all keyframes are told in, whichever camera saw them. nullopt where nobody has said.
  const std::optional<StereoCamera>& camera() const { return camera_; }
  void SetCamera(const StereoCamera& camera) { camera_ = camera; }

  const IdMap<MapKeyframe>& keyframes() const { return keyframes_; }
  const IdMap<MapPoint>& points() const { return points_; }
  const IdMap<MapLine>& lines() const { return lines_; }
  /// nullptr where there is none.
  const MapKeyframe* FindKeyframe(int64_t id) const;
  const MapPoint* FindPoint(int64_t id) const;
  const MapLine* FindLine(int64_t id) const;
  MapTotals Totals() const;
  /// Loops that have been closed, in that order. They stay when a keyframe of theirs is removed.
  const std::vector<LoopEdge>& loops() const { return loops_; }

  /// Add, or replace what has the same id. Observations of another landmark by the same feature are taken from that
  /// one.
  void Put(const MapKeyframe& keyframe);
  void Put(const MapPoint& point);
  void Put(const MapLine& line);
  /// A keyframe goes with its observations; landmarks that lose their last observation go too, and its children in
  /// the spanning tree move to their best neighbour (`kParent`; its parent where they have none).
  void RemoveKeyframe(int64_t id);
  void RemovePoint(int64_t id);
  void RemoveLine(int64_t id);
  void Add(const LoopEdge& loop);
  void Clear();

  /// Moves, without touching the observations.
  void SetPose(int64_t keyframe_id, const SE3& T_w_kf, const Matrix6d& covariance);
  void SetPosition(int64_t point_id, const Eigen::Vector3d& p_w, const Eigen::Matrix3d& covariance);
  void SetSegment(int64_t line_id, const Segment3& segment_w, const Eigen::Matrix3d& covariance_p,
                  const Eigen::Matrix3d& covariance_q);

  /// A correction: moves keyframes, and each landmark rigidly with its anchor (`AnchorOf`), covariances turned along.
  /// What has not been changed otherwise since the last `TakeChanges` counts as moved, so that a correction of a
  /// large map is told by the poses alone. Keyframes that are not in the map, or are there already, are passed over.
  void Move(const std::map<int64_t, SE3>& T_w_kf);
  /// Covariances alone.
  void SetCovariances(const std::map<int64_t, Matrix6d>& covariances);

  const FeatureLandmarks& LandmarksOf(int64_t keyframe_id) const;
  int Shared(int64_t a, int64_t b) const;
  /// Keyframes that share at least `min_shared` landmarks (>= 1) with this one: most shared first, then by id.
  std::vector<Neighbour> Neighbours(int64_t keyframe_id, int min_shared) const;
  std::vector<int64_t> Children(int64_t keyframe_id) const;

  /// What has changed since the last call.
  MapChanges TakeChanges();
  /// For those who tell nobody.
  void ForgetChanges();

 private:
  /// Where everything about one feature type of landmarks stands.
  template <class Landmark>
  struct Kind {
    IdMap<Landmark>& landmarks;
    std::vector<int64_t> FeatureLandmarks::*of;
    std::vector<int64_t>& touched;
    int64_t& n_observations;
  };
  /// Ids of what came, changed or went, as often as it did: what is in the map now has changed, the rest is gone.
  struct Touched {
    std::vector<int64_t> keyframes, points, lines;
  };
  /// What `Move` works with: how the moved keyframes went, and of which of them it cannot be told by their move
  /// alone.
  struct Moves {
    std::map<int64_t, SE3> T_new_old;  // of w
    std::set<int64_t> retold;
  };
  Kind<MapPoint> Points();
  Kind<MapLine> Lines();

  template <class Landmark>
  void PutLandmark(const Landmark& landmark, Kind<Landmark> kind);
  template <class Landmark>
  void RemoveLandmark(int64_t id, Kind<Landmark> kind);
  template <class Landmark>
  void SetObservations(Landmark& landmark, std::vector<Observation> observations, Kind<Landmark> kind);
  template <class Landmark>
  void FollowObservations(const std::vector<Observation>& old, const Landmark& landmark, Kind<Landmark> kind);
  template <class Landmark>
  void DropObservationsOf(int64_t keyframe_id, Kind<Landmark> kind);
  void CountShared(const std::vector<Observation>& observations, const std::vector<Observation>& others, int sign);
  template <class Landmark>
  void MoveLandmarks(const Moves& moves, Kind<Landmark> kind);

  std::optional<StereoCamera> camera_;
  IdMap<MapKeyframe> keyframes_;
  IdMap<MapPoint> points_;
  IdMap<MapLine> lines_;
  IdMap<FeatureLandmarks> landmarks_of_;
  IdMap<SharedCounts> shared_;
  IdMap<std::set<int64_t>> children_;
  int64_t n_point_observations_ = 0;
  int64_t n_line_observations_ = 0;
  std::vector<LoopEdge> loops_;
  size_t n_loops_told_ = 0;
  Touched touched_;
  /// Where keyframes were moved to that nothing else had changed by then.
  std::map<int64_t, SE3> moved_;
};

}  // namespace plslam
