#include "tools/pose_graph/pose_graph_of_map.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace plslam {
namespace {

// As far back odometry says how certain an edge is; keyframes farther apart see the same again, as after a loop.
constexpr int kMaxSteps = 20;
// Of an edge to a keyframe that odometry says nothing about, the first of a session.
constexpr double kUnmeasuredSigma_m = 0.05;
constexpr double kUnmeasuredSigma_rad = 0.01;
// Keyframes that share next to nothing are not joined by next to nothing.
constexpr double kMaxWeakening = 10.0;

Matrix6d UnmeasuredCovariance() {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(kUnmeasuredSigma_m), Eigen::Vector3d::Constant(kUnmeasuredSigma_rad);
  return sigmas.cwiseAbs2().asDiagonal();
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
    const std::map<int64_t, Matrix6d> odometry = OdometryTo(keyframe);
    for (const int64_t id : older) {
      const auto measured = odometry.find(id);
      const Matrix6d covariance = measured != odometry.end() ? measured->second : CovarianceByShared(id, keyframe);
      // What odometry knew is not counted several times.
      const auto information = InformationFromCovariance(static_cast<double>(older.size()) * covariance);
      const SE3 T_a_b = map_.FindKeyframe(id)->T_w_kf.Inverse() * keyframe.T_w_kf;
      if (information) Add(id, keyframe.id, T_a_b, *information, false);
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
  /// Covariances of the motions to a keyframe from those before it in its session, as odometry measured them.
  std::map<int64_t, Matrix6d> OdometryTo(const MapKeyframe& keyframe) const {
    std::map<int64_t, Matrix6d> covariances;
    SE3 T_x_kf;
    Matrix6d covariance = Matrix6d::Zero();
    const MapKeyframe* x = &keyframe;
    for (int step = 0; step < kMaxSteps && InformationFromCovariance(x->relative_covariance); ++step) {
      const MapKeyframe* const previous = map_.FindKeyframe(x->previous_id);
      if (previous == nullptr) break;
      covariance = ComposeCovariance(x->relative_covariance, T_x_kf, covariance);
      T_x_kf = x->T_prevkf_kf * T_x_kf;
      covariances[previous->id] = covariance;
      x = previous;
    }
    return covariances;
  }

  Matrix6d CovarianceByShared(int64_t id, const MapKeyframe& keyframe) const {
    if (!InformationFromCovariance(keyframe.relative_covariance)) return UnmeasuredCovariance();
    const double with_previous = std::max(1, map_.Shared(keyframe.previous_id, keyframe.id));
    const double weakening = with_previous / std::max(1, map_.Shared(id, keyframe.id));
    return std::clamp(weakening, 1.0, kMaxWeakening) * keyframe.relative_covariance;
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
