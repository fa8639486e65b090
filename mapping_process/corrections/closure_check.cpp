// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/corrections/closure_check.h"

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/geometry/symmetric.h"
#include "mapping_process/insertion/loop_edges.h"

namespace plslam::mapping {
namespace {

// Beyond this, sums of squared coordinates lose accuracy of metres.
constexpr double kFarthest_m = 1e7;
// Tolerance of the norm of a unit quaternion after transmission.
constexpr double kUnit = 1e-6;

bool IsPose(const SE3& T) {
  return T.IsFinite() && T.translation().cwiseAbs().maxCoeff() < kFarthest_m &&
         std::abs(T.rotation().norm() - 1.0) < kUnit;
}

template <class AnId>
bool IsGiven(AnId id, AnId next) {
  return id >= 0 && id < next;
}

std::string WrongVersion(const MapVersion& version, const AssignedIds& given) {
  if (!version.map.Matches(given.version.map)) return "it was computed on another map";
  if (version.numbering != given.version.numbering) return {};
  if (version.number > given.version.number) {
    return fmt::format("it was computed on version {} of the map, which is at {}", version.number,
                       given.version.number);
  }
  if (version.number < given.structural_version) {
    return fmt::format("it corrects version {} of the map, whose structure changed in version {}", version.number,
                       given.structural_version);
  }
  return {};
}

std::string WrongPoses(const std::vector<CorrectedPose>& poses, KeyframeId next_keyframe) {
  KeyframeId last = -1;
  for (const CorrectedPose& pose : poses) {
    if (!IsGiven(pose.keyframe_id, next_keyframe)) {
      return fmt::format("it moves keyframe {}, but the newest id of this map is {}", pose.keyframe_id,
                         next_keyframe.value - 1);
    }
    if (pose.keyframe_id <= last)
      return fmt::format("its poses are not in ascending order at keyframe {}", pose.keyframe_id);
    if (!IsPose(pose.T_w_kf)) return fmt::format("the new pose of keyframe {} is invalid", pose.keyframe_id);
    last = pose.keyframe_id;
  }
  return {};
}

std::string WrongEdges(const std::vector<LoopEdge>& edges, KeyframeId next_keyframe) {
  for (const LoopEdge& edge : edges) {
    const KeyframeId a = edge.old_keyframe_id;
    const KeyframeId b = edge.keyframe_id;
    if (!IsGiven(a, next_keyframe) || !IsGiven(b, next_keyframe) || a == b) {
      return fmt::format("its loop joins keyframes {} and {}, but the newest id of this map is {}", a, b,
                         next_keyframe.value - 1);
    }
    if (!IsPose(edge.T_old_kf)) return fmt::format("the relative pose of keyframes {} and {} is invalid", a, b);
    if (!edge.covariance.allFinite() || !IsPositiveDefinite<6>(edge.covariance)) {
      return fmt::format("the covariance of its loop between keyframes {} and {} is invalid", a, b);
    }
  }
  return {};
}

std::string WrongPairs(const char* kind, const std::vector<SameLandmarks>& pairs, LandmarkId next) {
  for (const SameLandmarks& pair : pairs) {
    if (IsGiven(pair.a, next) && IsGiven(pair.b, next)) continue;
    return fmt::format("it joins {} {} and {}, but the newest id of this map is {}", kind, pair.a, pair.b,
                       next.value - 1);
  }
  return {};
}

bool HasEffect(const LoopClosure& closure, const Map& map) {
  const auto is_there = [&map](const CorrectedPose& pose) { return map.FindKeyframe(pose.keyframe_id) != nullptr; };
  const auto are_there = [&map](const LoopEdge& edge) {
    return map.FindKeyframe(edge.old_keyframe_id) != nullptr && map.FindKeyframe(edge.keyframe_id) != nullptr;
  };
  return std::any_of(closure.poses.begin(), closure.poses.end(), is_there) ||
         std::any_of(closure.edges.begin(), closure.edges.end(), are_there);
}

}  // namespace

std::string WhyNotOfMap(const LoopClosure& closure, const AssignedIds& given, const Map& map) {
  std::string wrong = closure.map_version ? WrongVersion(*closure.map_version, given) : "";
  if (!wrong.empty()) return wrong;
  if (closure.kind == LoopClosure::Kind::kLoop && closure.edges.empty()) return "its loop has no edges";
  wrong = WrongPoses(closure.poses, given.next_keyframe);
  if (wrong.empty()) wrong = WrongEdges(closure.edges, given.next_keyframe);
  if (wrong.empty()) wrong = WrongPairs("points", closure.points, given.next_landmark.next_point);
  if (wrong.empty()) wrong = WrongPairs("lines", closure.lines, given.next_landmark.next_line);
  if (wrong.empty() && !HasEffect(closure, map)) wrong = "none of its keyframes is in the map any more";
  return wrong;
}

namespace {

/// Maps keyframe ids of a closure to ids of this map.
class Ids {
 public:
  Ids(const std::vector<NamedKeyframe>& names, const Map& map) {
    std::map<KeyframeName, KeyframeId> by_name;
    for (const auto& [id, keyframe] : map.keyframes()) by_name[keyframe.name] = id;
    for (const NamedKeyframe& named : names) {
      const auto here = by_name.find(named.name);
      if (here != by_name.end()) ids_[named.keyframe_id] = here->second;
      const KeyframeId id_here = here != by_name.end() ? here->second : -1;
      // A keyframe that was culled has no id here; its id in the closure remains valid unless another keyframe has it.
      differ_ = differ_ ||
                (id_here != named.keyframe_id && (id_here >= 0 || map.FindKeyframe(named.keyframe_id) != nullptr));
    }
  }

  /// Whether a keyframe has another id in this map, or its id belongs to another keyframe.
  bool differ() const { return differ_; }

  std::optional<KeyframeId> Here(KeyframeId id) const {
    const auto here = ids_.find(id);
    return here == ids_.end() ? std::nullopt : std::optional(here->second);
  }

 private:
  std::map<KeyframeId, KeyframeId> ids_;
  bool differ_ = false;
};

std::optional<LoopEdge> Translated(const LoopEdge& edge, const Ids& ids) {
  const auto a = ids.Here(edge.old_keyframe_id);
  const auto b = ids.Here(edge.keyframe_id);
  if (!a || !b) return std::nullopt;
  LoopEdge translated = edge;
  translated.old_keyframe_id = *a;
  translated.keyframe_id = *b;
  return *a <= *b ? translated : Reversed(translated);
}

}  // namespace

LoopClosure InIdsOf(const Map& map, const LoopClosure& closure, MapIds map_ids) {
  const Ids ids(closure.names, map);
  if (map_ids == MapIds::kPerhapsSame && !ids.differ()) return closure;
  LoopClosure translated = closure;
  translated.edges.clear();
  translated.poses.clear();
  for (const LoopEdge& edge : closure.edges) {
    if (const auto here = Translated(edge, ids)) translated.edges.push_back(*here);
  }
  for (const CorrectedPose& pose : closure.poses) {
    if (const auto here = ids.Here(pose.keyframe_id)) translated.poses.push_back({*here, pose.T_w_kf});
  }
  std::sort(translated.poses.begin(), translated.poses.end(),
            [](const CorrectedPose& a, const CorrectedPose& b) { return a.keyframe_id < b.keyframe_id; });
  for (NamedKeyframe& named : translated.names)
    named.keyframe_id = ids.Here(named.keyframe_id).value_or(KeyframeId());
  std::erase_if(translated.names, [](const NamedKeyframe& named) { return named.keyframe_id < 0; });
  std::sort(translated.names.begin(), translated.names.end(),
            [](const NamedKeyframe& a, const NamedKeyframe& b) { return a.keyframe_id < b.keyframe_id; });
  translated.points.clear();
  translated.lines.clear();
  return translated;
}

}  // namespace plslam::mapping
