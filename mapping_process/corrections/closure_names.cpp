#include "mapping_process/corrections/closure_names.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "mapping_process/corrections/loop_edges.h"

namespace plslam {
namespace {

using Name = std::pair<int64_t, int64_t>;

/// From the ids of a closure to those of a map.
class Ids {
 public:
  Ids(const std::vector<KeyframeName>& names, const Map& map) {
    std::map<Name, int64_t> by_name;
    for (const auto& [id, keyframe] : map.keyframes()) by_name[{keyframe.session, keyframe.session_keyframe_id}] = id;
    for (const KeyframeName& name : names) {
      const auto here = by_name.find({name.session, name.session_keyframe_id});
      if (here != by_name.end()) ids_[name.keyframe_id] = here->second;
      const int64_t id_here = here != by_name.end() ? here->second : -1;
      // One that was culled since has none; its id is still its own, as long as no other has it.
      differ_ =
          differ_ || (id_here != name.keyframe_id && (id_here >= 0 || map.FindKeyframe(name.keyframe_id) != nullptr));
    }
  }

  /// A keyframe has another id here, or its id is that of another.
  bool differ() const { return differ_; }

  std::optional<int64_t> Here(int64_t id) const {
    const auto here = ids_.find(id);
    return here == ids_.end() ? std::nullopt : std::optional(here->second);
  }

 private:
  std::map<int64_t, int64_t> ids_;
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
  for (KeyframeName& name : translated.names) name.keyframe_id = ids.Here(name.keyframe_id).value_or(-1);
  std::erase_if(translated.names, [](const KeyframeName& name) { return name.keyframe_id < 0; });
  std::sort(translated.names.begin(), translated.names.end(),
            [](const KeyframeName& a, const KeyframeName& b) { return a.keyframe_id < b.keyframe_id; });
  translated.points.clear();
  translated.lines.clear();
  translated.map_version = 0;
  return translated;
}

}  // namespace plslam
