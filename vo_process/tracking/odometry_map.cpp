#include <algorithm>
#include <map>
#include <utility>

#include "vo_process/tracking/odometry.h"

// How odometry takes over what the map knows, and how a camera goes on in a map that it was found in.

namespace plslam {

bool Odometry::Adopt(const Map& map, int64_t session, int64_t keyframe_id) {
  const auto patch = keyframe_log_.PatchAround(map, session, keyframe_id, options_.map.local_keyframes);
  if (!patch) return false;
  T_w_odom_ = patch->T_w_odom;
  is_in_map_ = true;
  const bool keep_own = options_.map.landmarks == "unknown";
  if (!dormant_) {
    landmarks_.Adopt(*patch, keep_own);
    return true;
  }
  // While lost, the map is about the landmarks from before; names are drawn from one source.
  LocalLandmarks& before = dormant_->landmarks;
  before.NumberBehind(landmarks_);
  before.Adopt(*patch, keep_own);
  landmarks_.NumberBehind(before);
  return true;
}

bool Odometry::AdoptAround(const Map& map) {
  std::map<int64_t, int> counts;
  const auto count = [&](const auto& landmarks, const auto& find) {
    for (const auto& landmark : landmarks) {
      if (landmark.map_id < 0 || landmark.unseen_frames > 0 || find(landmark.map_id) == nullptr) continue;
      for (const Sight& sight : find(landmark.map_id)->sights) ++counts[sight.keyframe_id];
    }
  };
  count(landmarks_.points.landmarks(), [&map](int64_t id) { return map.FindPoint(id); });
  count(landmarks_.lines.landmarks(), [&map](int64_t id) { return map.FindLine(id); });
  const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto best = std::max_element(counts.begin(), counts.end(), fewer);
  if (dormant_ || best == counts.end()) return false;
  const auto patch = PatchAt(map, best->first, T_w_odom_, options_.map.local_keyframes);
  if (!patch) return false;
  landmarks_.Adopt(*patch, false);
  return true;
}

bool Odometry::Relocalise(const Map& map, int64_t map_keyframe_id, const SE3& T_w_odom) {
  const auto patch = PatchAt(map, map_keyframe_id, T_w_odom, options_.map.local_keyframes);
  if (!patch) return false;
  relocalised_ = Relocalised{LocalLandmarks(camera_, options_), T_w_odom};
  LocalLandmarks& landmarks = relocalised_->landmarks;
  landmarks.NumberBehind(landmarks_);
  landmarks.Adopt(*patch, false);
  landmarks.CountAsSeen();
  landmarks_.NumberBehind(landmarks);
  return true;
}

std::optional<Odometry::Tracked> Odometry::FindRelocalised(const TrackedFrame& frame,
                                                           const MotionPrediction& prediction) {
  Relocalised place = *std::exchange(relocalised_, std::nullopt);
  auto found = aligner_.Align(place.landmarks, frame, T_odom_c_, prediction, ExpectedWeight());
  if (!found || found->weak) return std::nullopt;
  const bool was_lost = !KeepOdometry(frame, prediction, *found, place);
  place.landmarks.NumberBehind(landmarks_);
  landmarks_ = std::move(place.landmarks);
  T_w_odom_ = place.T_w_odom;
  is_in_map_ = true;
  dormant_.reset();
  return Tracked{std::move(*found), was_lost ? Reference::kRelocalised : Reference::kLocalised};
}

/// Where the camera had not lost its way, what it was found by gives way: pose and landmarks as odometry has them.
bool Odometry::KeepOdometry(const TrackedFrame& frame, const MotionPrediction& prediction, Alignment& found,
                            Relocalised& place) const {
  if (dormant_) return false;
  const auto own = aligner_.Align(landmarks_, frame, T_odom_c_, prediction, ExpectedWeight());
  if (!own || own->weak) return false;
  const SE3 T_odom_place = own->T_odom_c * found.T_odom_c.Inverse();
  place.landmarks.Move(T_odom_place);
  place.T_w_odom = place.T_w_odom * T_odom_place.Inverse();
  found.T_odom_c = own->T_odom_c;
  found.covariance = own->covariance;
  return true;
}

}  // namespace plslam
