// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/map.h"
#include "mapping_process/insertion/visits.h"

namespace plslam::mapping {

/// Landmarks of earlier visits that later visits do not find where they should. One that two visits in a row have missed
/// is not there any more: furniture was moved, a poster replaced.
class MissedLandmarks {
 public:
  /// Compares the landmarks that a new keyframe observes with those that earlier visits observed from about the same
  /// position, and removes those that are missed for the second visit in a row. A keyframe that finds only few of them says
  /// nothing about them: it is dark, blurred or covered. `camera`: of the keyframe.
  void Compare(KeyframeId keyframe_id, const Visits& visits, const StereoCamera& camera, Map& map);

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.points_, self.lines_);
  }

 private:
  struct Entry {
    int64_t visits = 0;     ///< that have missed it in a row
    Visits::Moment newest;  ///< that missed it

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.visits, self.newest);
    }
  };
  /// By landmark.
  using Table = std::map<LandmarkId, Entry>;

  template <class Type>
  void Update(const std::vector<LandmarkId>& missed, const MapKeyframe& keyframe, const Visits& visits, Table& table,
              Map& map);

  Table points_;
  Table lines_;
};

}  // namespace plslam::mapping
