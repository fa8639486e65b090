// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/forgetting.h"

#include <algorithm>
#include <map>
#include <unordered_map>
#include <unordered_set>

#include "core/map/landmark_types.h"

namespace plslam::mapping {
namespace {

// Mean of 1 / observations over the landmarks of a keyframe, above which it is needed.
constexpr double kNeeded = 0.5;

// The map without the keyframes that were chosen for removal.
class Remaining {
 public:
  Remaining(const Map& map, const Visits& visits) : map_(map), visits_(visits) {}

  // Returns whether an earlier visit observed more than half of the landmarks of the keyframe.
  bool IsKnown(const MapKeyframe& keyframe) const {
    std::vector<KeyframeId> oldest;  // observations of the landmarks
    AddOldest<PointType>(keyframe.id, oldest);
    AddOldest<LineType>(keyframe.id, oldest);
    if (oldest.empty()) return false;
    const auto middle = oldest.begin() + static_cast<std::ptrdiff_t>(oldest.size() / 2);
    std::nth_element(oldest.begin(), middle, oldest.end());
    return visits_.IsBefore(*map_.FindKeyframe(*middle), keyframe);
  }

  // Returns the mean share of the keyframe in the observations of its landmarks.
  double Loss(const MapKeyframe& keyframe) const {
    Tally tally;
    Count<PointType>(keyframe.id, points_, tally);
    Count<LineType>(keyframe.id, lines_, tally);
    return tally.landmarks > 0.0 ? tally.shares / tally.landmarks : 0.0;
  }

  void Remove(KeyframeId id) {
    removed_.insert(id);
    for (const LandmarkId point_id : PointType::Of(map_, id)) points_[point_id] += 1;
    for (const LandmarkId line_id : LineType::Of(map_, id)) lines_[line_id] += 1;
  }

 private:
  // Observations of landmarks by removed keyframes.
  using Lost = std::unordered_map<LandmarkId, int>;
  struct Tally {
    double landmarks = 0.0;
    double shares = 0.0;
  };

  template <class Type>
  void Count(KeyframeId keyframe_id, const Lost& lost, Tally& tally) const {
    for (const LandmarkId id : Type::Of(map_, keyframe_id)) {
      if (id < 0) continue;
      const auto gone = lost.find(id);
      const int left =
          static_cast<int>(Type::Find(map_, id)->observations.size()) - (gone == lost.end() ? 0 : gone->second);
      tally.landmarks += 1.0;
      tally.shares += 1.0 / std::max(left, 1);
    }
  }

  template <class Type>
  void AddOldest(KeyframeId keyframe_id, std::vector<KeyframeId>& oldest) const {
    for (const LandmarkId id : Type::Of(map_, keyframe_id)) {
      if (id < 0) continue;
      const std::vector<Observation>& observations = Type::Find(map_, id)->observations;
      const auto left = std::find_if(
          observations.begin(), observations.end(),
          [this](const Observation& observation) { return !removed_.contains(observation.keyframe_id()); });
      if (left != observations.end()) oldest.push_back(left->keyframe_id());
    }
  }

  const Map& map_;
  const Visits& visits_;
  std::unordered_set<KeyframeId> removed_;
  Lost points_, lines_;
};

}  // namespace

std::vector<KeyframeId> KeyframesToForget(const Map& map, const Visits& visits, size_t max_keyframes,
                                          const std::function<bool(const MapKeyframe&)>& is_kept) {
  std::vector<KeyframeId> forgotten;
  if (map.keyframes().size() <= max_keyframes) return forgotten;
  const size_t n = map.keyframes().size() - max_keyframes;
  Remaining remaining(map, visits);
  std::map<KeyframeId, double> losses;  // of the keyframes that may be removed
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (forgotten.size() == n) return forgotten;
    if (is_kept(keyframe)) continue;
    if (remaining.IsKnown(keyframe)) {
      remaining.Remove(id);
      forgotten.push_back(id);
    } else {
      losses[id] = 0.0;
    }
  }
  for (auto& [id, loss] : losses) loss = remaining.Loss(*map.FindKeyframe(id));
  while (forgotten.size() < n && !losses.empty()) {
    const auto least = std::min_element(losses.begin(), losses.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
    const KeyframeId id = least->second <= kNeeded ? least->first : losses.begin()->first;
    remaining.Remove(id);
    losses.erase(id);
    forgotten.push_back(id);
    for (const Map::Neighbour& neighbour : map.Neighbours(id, 1)) {
      const auto changed = losses.find(neighbour.keyframe_id);
      if (changed != losses.end()) changed->second = remaining.Loss(*map.FindKeyframe(neighbour.keyframe_id));
    }
  }
  return forgotten;
}

}  // namespace plslam::mapping
