// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/forgetting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace plslam::mapping {
namespace {

constexpr double kLeastStep_m = 1e-3;
// Largest angle between the optical axes of views of the same scene.
constexpr double kSameWay_deg = 15.0;
// Distance at which a camera has left a place, relative to the step between keyframes.
constexpr double kElsewhere = 3.0;

// Median length of the motions between consecutive keyframes.
double Step_m(const Map& map) {
  std::vector<double> steps_m;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.previous_id >= 0) steps_m.push_back(keyframe.T_prevkf_kf.translation().norm());
  }
  if (steps_m.empty()) return kLeastStep_m;
  const auto middle = steps_m.begin() + static_cast<std::ptrdiff_t>(steps_m.size() / 2);
  std::nth_element(steps_m.begin(), middle, steps_m.end());
  return std::max(*middle, kLeastStep_m);
}

double Distance_m(const MapKeyframe& a, const MapKeyframe& b) {
  return (a.T_w_kf.translation() - b.T_w_kf.translation()).norm();
}

// Grid of keyframes by position; a cell is as wide as the largest distance between a keyframe and its replacement.
class KeyframePlaces {
 public:
  KeyframePlaces(const Map& map, double near_m) : map_(map), near_m_(near_m) {
    for (const auto& [id, keyframe] : map.keyframes()) {
      cells_[CellOf(keyframe)].push_back(id);
      sessions_[keyframe.session].push_back(id);
    }
  }

  bool IsReplaced(const MapKeyframe& keyframe) const {
    const int64_t left_id = LeftAt(keyframe);
    const Cell cell = CellOf(keyframe);
    for (int64_t i = 0; i < 27; ++i) {
      const auto beside = cells_.find({cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1});
      if (beside == cells_.end()) continue;
      // Ids ascend: start from the newest.
      for (auto id = beside->second.rbegin(); id != beside->second.rend() && *id > keyframe.id; ++id) {
        const MapKeyframe& newer = *map_.FindKeyframe(*id);
        const bool is_later = newer.session != keyframe.session || newer.id > left_id;
        if (is_later && ShowsTheSame(newer, keyframe)) return true;
      }
    }
    return false;
  }

 private:
  using Cell = std::array<int64_t, 3>;

  Cell CellOf(const MapKeyframe& keyframe) const {
    Cell cell{};
    for (int i = 0; i < 3; ++i)
      cell[i] = static_cast<int64_t>(std::floor(keyframe.T_w_kf.translation()[i] / near_m_));
    return cell;
  }

  // Id of the first later keyframe of the session that is elsewhere, or the largest integer.
  int64_t LeftAt(const MapKeyframe& keyframe) const {
    const std::vector<int64_t>& session = sessions_.at(keyframe.session);
    const auto is_elsewhere = [&](int64_t id) {
      return Distance_m(*map_.FindKeyframe(id), keyframe) > kElsewhere * near_m_;
    };
    const auto left =
        std::find_if(std::upper_bound(session.begin(), session.end(), keyframe.id), session.end(), is_elsewhere);
    return left == session.end() ? std::numeric_limits<int64_t>::max() : *left;
  }

  bool ShowsTheSame(const MapKeyframe& a, const MapKeyframe& b) const {
    static const double kLeastCosine = std::cos(kSameWay_deg * kRadPerDeg);
    return Distance_m(a, b) <= near_m_ && a.T_w_kf.R().col(2).dot(b.T_w_kf.R().col(2)) >= kLeastCosine;
  }

  const Map& map_;
  double near_m_;
  std::map<Cell, std::vector<int64_t>> cells_;
  std::map<int64_t, std::vector<int64_t>> sessions_;
};

}  // namespace

std::vector<int64_t> KeyframesToForget(const Map& map, size_t max_keyframes,
                                       const std::function<bool(const MapKeyframe&)>& is_kept) {
  std::vector<int64_t> forgotten;
  if (map.keyframes().size() <= max_keyframes) return forgotten;
  const size_t n = map.keyframes().size() - max_keyframes;
  const KeyframePlaces places(map, Step_m(map));
  std::vector<int64_t> not_replaced;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (forgotten.size() == n) return forgotten;
    if (is_kept(keyframe)) continue;
    (places.IsReplaced(keyframe) ? forgotten : not_replaced).push_back(id);
  }
  for (const int64_t id : not_replaced) {
    if (forgotten.size() == n) break;
    forgotten.push_back(id);
  }
  return forgotten;
}

}  // namespace plslam::mapping
