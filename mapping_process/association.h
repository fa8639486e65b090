#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/keyframe.h"
#include "mapping_process/options.h"
#include "mapping_process/stored_keyframe.h"

namespace plslam {

/// The landmark of the map that each feature of a keyframe shows, or -1; no landmark twice. As long as the features.
struct Association {
  std::vector<int64_t> points;
  std::vector<int64_t> lines;

  /// Lines count twice: each has two endpoints.
  int Weight() const;
};

/// Landmarks of the tracker (by session and its ids) and the landmarks of the map they became.
class TrackerLandmarks {
 public:
  /// What the tracker says of the features: landmarks it was given, and those of its own that earlier keyframes brought.
  Association Claims(const Keyframe& keyframe, const Map& map) const;

  /// Remembers which landmarks the features of a keyframe turned out to show, and forgets what was not seen for long.
  void Learn(const Keyframe& keyframe, const Map::FeatureLandmarks& shown);

 private:
  struct Entry {
    int64_t map_id = -1;
    int64_t keyframe_id = -1;
  };
  using Table = std::map<int64_t, Entry>;
  static void Learn(const std::vector<int64_t>& tracker_ids, const std::vector<int64_t>& shown, int64_t keyframe_id,
                    Table& table);

  int64_t session_ = 0;
  Table points_;
  Table lines_;
};

/// Landmarks to look for, by id.
struct LocalMap {
  std::vector<int64_t> points;
  std::vector<int64_t> lines;
};

/// What the best-connected keyframes of the associated landmarks see (PL-SLAM §V.A), without those already associated.
/// Where nothing is associated (the tracker was lost, or gives no ids): what `previous_id` (-1: none) and those before it
/// in its session see.
LocalMap LocalMapOf(const Association& association, int64_t previous_id, const Map& map, int max_keyframes);

/// Searches the landmarks among the features that show none yet, by projecting them with the pose, and adds what is
/// found.
void SearchByProjection(const Map& map, const LocalMap& local, const SE3& T_w_kf, const StereoFeatures& features,
                        const StereoCamera& camera, const MappingOptions& options, Association& association);

}  // namespace plslam
