#include "core/optim/pose_graph_of_map.h"

#include <algorithm>
#include <set>

namespace plslam {
namespace {

// Of an edge to a keyframe that odometry says nothing about, the first of a session.
constexpr double kUnmeasuredSigma_m = 0.05;
constexpr double kUnmeasuredSigma_rad = 0.01;
// Keyframes that share next to nothing are not joined by next to nothing.
constexpr double kMaxWeakening = 10.0;

Matrix6d UnmeasuredInformation() {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(kUnmeasuredSigma_m), Eigen::Vector3d::Constant(kUnmeasuredSigma_rad);
  return sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
}

class Builder {
 public:
  explicit Builder(const Map& map) : map_(map) {
    for (const auto& [id, keyframe] : map.keyframes()) {
      result_.keyframe_ids.push_back(id);
      result_.graph.poses.push_back({keyframe.T_w_kf, result_.graph.poses.empty()});
    }
  }

  void AddKeyframe(const MapKeyframe& keyframe) {
    std::set<int64_t> older;
    for (const int64_t id : {keyframe.parent_id, keyframe.previous_id}) {
      if (map_.FindKeyframe(id) != nullptr) older.insert(id);
    }
    for (const Map::Neighbour& neighbour : map_.Neighbours(keyframe.id, Map::kEssential)) {
      if (neighbour.keyframe_id < keyframe.id) older.insert(neighbour.keyframe_id);
    }
    if (older.empty()) return;
    const Matrix6d information =
        InformationFromCovariance(keyframe.relative_covariance).value_or(UnmeasuredInformation());
    for (const int64_t id : older) {
      const SE3 T_a_b = map_.FindKeyframe(id)->T_w_kf.Inverse() * keyframe.T_w_kf;
      Add(id, keyframe.id, T_a_b, information / Weakening(id, keyframe), false);
    }
  }

  void AddLoop(const LoopEdge& loop) {
    const bool there = map_.FindKeyframe(loop.old_keyframe_id) != nullptr &&
                       map_.FindKeyframe(loop.keyframe_id) != nullptr && loop.old_keyframe_id != loop.keyframe_id;
    const auto information = InformationFromCovariance(loop.covariance);
    if (there && information) Add(loop.old_keyframe_id, loop.keyframe_id, loop.T_old_kf, *information, true);
  }

  MapPoseGraph Take() && { return std::move(result_); }

 private:
  double Weakening(int64_t id, const MapKeyframe& keyframe) const {
    const double with_previous = std::max(1, map_.Shared(keyframe.previous_id, keyframe.id));
    return std::clamp(with_previous / std::max(1, map_.Shared(id, keyframe.id)), 1.0, kMaxWeakening);
  }

  int Place(int64_t id) const {
    const auto& ids = result_.keyframe_ids;
    return static_cast<int>(std::lower_bound(ids.begin(), ids.end(), id) - ids.begin());
  }

  void Add(int64_t a, int64_t b, const SE3& T_a_b, const Matrix6d& information, bool robust) {
    result_.graph.edges.push_back({Place(a), Place(b), T_a_b, information, robust});
  }

  const Map& map_;
  MapPoseGraph result_;
};

}  // namespace

MapPoseGraph PoseGraphOf(const Map& map, const std::vector<LoopEdge>& more_loops) {
  Builder builder(map);
  for (const auto& [id, keyframe] : map.keyframes()) builder.AddKeyframe(keyframe);
  for (const LoopEdge& loop : map.loops()) builder.AddLoop(loop);
  for (const LoopEdge& loop : more_loops) builder.AddLoop(loop);
  return std::move(builder).Take();
}

}  // namespace plslam
