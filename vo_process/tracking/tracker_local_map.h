// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "core/map/map.h"

namespace plslam::vo {

/// A landmark of the map and the landmarks of the tracker that keyframes have shown to be the same.
template <class Landmark>
struct Adopted {
  const Landmark* landmark = nullptr;
  std::vector<int64_t> tracker_ids;
};

/// The part of the map around a keyframe; points into that map.
struct TrackerLocalMap {
  SE3 T_w_odom;
  /// Of the camera that octaves and distances of the points are told in; 0: of the tracker's.
  double f_px = 0.0;
  std::vector<Adopted<MapPoint>> points;
  std::vector<Adopted<MapLine>> lines;
};

/// What a keyframe of the map and its best neighbours see; `T_w_odom` is handed on. nullopt where the map does not
/// have the keyframe.
std::optional<TrackerLocalMap> LocalMapAt(const Map& map, int64_t keyframe_id, const SE3& T_w_odom,
                                          int max_keyframes);

/// Which landmarks the tracker's last keyframes showed, by feature: the link between its landmarks and those of the
/// map.
class KeyframeLog {
 public:
  void Add(int64_t keyframe_id, std::vector<int64_t> point_ids, std::vector<int64_t> line_ids);

  /// What the keyframe of the session and its best neighbours see, as the map knows it. nullopt where the map does
  /// not have the keyframe.
  std::optional<TrackerLocalMap> LocalMapAround(const Map& map, int64_t session, int64_t keyframe_id,
                                                int max_keyframes) const;

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.entries_);
  }

 private:
  struct Entry {
    int64_t keyframe_id = -1;
    std::vector<int64_t> point_ids;
    std::vector<int64_t> line_ids;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.keyframe_id, self.point_ids, self.line_ids);
    }
  };
  const Entry* Find(int64_t keyframe_id) const;
  template <class Type>
  std::vector<Adopted<typename Type::Landmark>> Adopt(const Map& map, int64_t session,
                                                      const std::vector<int64_t>& keyframes,
                                                      std::vector<int64_t> Entry::*ids) const;

  std::deque<Entry> entries_;
};

}  // namespace plslam::vo
