// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/map.h"

namespace plslam::vo {

/// A landmark of the map and the landmarks of the tracker that are the same according to keyframes.
template <class Landmark>
struct Adopted {
  const Landmark* landmark = nullptr;
  std::vector<TrackId> tracker_ids;
};

/// The part of the map around a keyframe; points into that map.
struct TrackerLocalMap {
  SE3 T_w_odom;
  /// Focal length of the camera to which octaves and distances of the points refer; 0: that of the tracker.
  double f_px = 0.0;
  std::vector<Adopted<MapPoint>> points;
  std::vector<Adopted<MapLine>> lines;
};

/// Returns the landmarks observed by a keyframe of the map and its best neighbours; `T_w_odom` is copied. Returns
/// nullopt if the map does not have the keyframe.
std::optional<TrackerLocalMap> LocalMapAt(const Map& map, KeyframeId keyframe_id, const SE3& T_w_odom,
                                          int max_keyframes);

/// Landmarks of the tracker's last keyframes, by feature: the link between its landmarks and those of the map.
class KeyframeLog {
 public:
  void Add(int64_t keyframe_id, std::vector<TrackId> point_ids, std::vector<TrackId> line_ids);

  /// Returns the landmarks observed by the keyframe of the session and its best neighbours, with their poses in the
  /// map. Returns nullopt if the map does not have the keyframe.
  std::optional<TrackerLocalMap> LocalMapAround(const Map& map, const KeyframeName& keyframe,
                                                int max_keyframes) const;

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.entries_);
  }

 private:
  struct Entry {
    int64_t keyframe_id = -1;
    std::vector<TrackId> point_ids;
    std::vector<TrackId> line_ids;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.keyframe_id, self.point_ids, self.line_ids);
    }
  };
  const Entry* Find(int64_t keyframe_id) const;
  template <class Type>
  std::vector<Adopted<typename Type::Landmark>> Adopt(const Map& map, SessionId session,
                                                      const std::vector<KeyframeId>& keyframes,
                                                      std::vector<TrackId> Entry::*ids) const;

  std::deque<Entry> entries_;
};

}  // namespace plslam::vo
