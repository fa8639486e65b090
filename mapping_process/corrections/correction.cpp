// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/corrections/correction.h"

#include <algorithm>
#include <utility>

#include "core/geometry/rotate_covariance.h"
#include "mapping_process/insertion/observations.h"

namespace plslam {
namespace {

// Keyframes of those that see a landmark with which it is tried to move; they are spread over its life.
constexpr size_t kTried = 4;

using Poses = std::map<int64_t, SE3>;

// What a correction does to a keyframe.
struct Moved {
  SE3 T_new_old;  // of w
  SE3 T_kf_w;
  bool moves = false;
};

int64_t CarrierOf(const MapKeyframe& keyframe, const Poses& named, const Poses& poses) {
  for (const Poses* found : {&named, &poses}) {
    for (const int64_t id : {keyframe.parent_id, keyframe.previous_id}) {
      if (found->contains(id)) return id;
    }
  }
  return -1;
}

bool IsSame(const SE3& a, const SE3& b) {
  return a.translation() == b.translation() && a.rotation().coeffs() == b.rotation().coeffs();
}

std::map<int64_t, Moved> MovesOf(const Poses& poses, const Map& map) {
  std::map<int64_t, Moved> moves;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const auto pose = poses.find(id);
    if (pose == poses.end() || IsSame(pose->second, keyframe.T_w_kf)) {
      moves[id] = {SE3(), keyframe.T_w_kf.Inverse(), false};
    } else {
      moves[id] = {pose->second * keyframe.T_w_kf.Inverse(), pose->second.Inverse(), true};
    }
  }
  return moves;
}

MapPoint MovedBy(const SE3& T_new_old, const MapPoint& point) {
  MapPoint moved;
  moved.p_w = T_new_old * point.p_w;
  moved.covariance = RotateCovariance(T_new_old.R(), point.covariance);
  return moved;
}

MapLine MovedBy(const SE3& T_new_old, const MapLine& line) {
  const Eigen::Matrix3d R = T_new_old.R();
  MapLine moved;
  moved.segment_w = {T_new_old * line.segment_w.p, T_new_old * line.segment_w.q};
  moved.covariance_p = RotateCovariance(R, line.covariance_p);
  moved.covariance_q = RotateCovariance(R, line.covariance_q);
  return moved;
}

void Place(int64_t id, const MapPoint& place, Map& map) { map.SetPosition(id, place.p_w, place.covariance); }
void Place(int64_t id, const MapLine& place, Map& map) {
  map.SetSegment(id, place.segment_w, place.covariance_p, place.covariance_q);
}

template <class Type>
double ErrorAt(const typename Type::Landmark& place, const std::vector<Observation>& observations,
               const std::vector<const Moved*>& moves, const KeyframeFeatures& features, const StereoCamera& camera) {
  double sum = 0.0;
  for (size_t i = 0; i < observations.size(); ++i) {
    const auto& seen =
        Type::Features(features.at(observations[i].keyframe_id))[static_cast<size_t>(observations[i].feature)];
    sum += ObservationError(place, seen, moves[i]->T_kf_w, camera);
  }
  return sum;
}

// Of the observations, the keyframe to move with; the newest of equals.
template <class Type>
const Moved& BestMove(const typename Type::Landmark& landmark, const std::vector<const Moved*>& moves,
                      const KeyframeFeatures& features, const StereoCamera& camera) {
  const size_t n = moves.size();
  if (n == 1) return *moves.front();
  const size_t tried = std::min(n, kTried);
  const Moved* best = nullptr;
  double least = 0.0;
  for (size_t i = 0; i < tried; ++i) {
    const Moved* candidate = moves[i * (n - 1) / (tried - 1)];
    const double error =
        ErrorAt<Type>(MovedBy(candidate->T_new_old, landmark), landmark.observations, moves, features, camera);
    if (best != nullptr && error > least) continue;
    best = candidate;
    least = error;
  }
  return *best;
}

template <class Type>
void MoveLandmarks(const std::map<int64_t, Moved>& moves, const KeyframeFeatures& features,
                   const StereoCamera& camera, Map& map) {
  std::vector<std::pair<int64_t, int64_t>> impossible;
  std::vector<const Moved*> of_observations;
  for (const auto& [id, landmark] : Type::Landmarks(map)) {
    of_observations.clear();
    for (const Observation& observation : landmark.observations)
      of_observations.push_back(&moves.at(observation.keyframe_id));
    if (std::none_of(of_observations.begin(), of_observations.end(), [](const Moved* move) { return move->moves; }))
      continue;
    const Moved& best = BestMove<Type>(landmark, of_observations, features, camera);
    if (best.moves) Place(id, MovedBy(best.T_new_old, landmark), map);
    for (size_t i = 0; i < of_observations.size(); ++i) {
      if (IsBehind(landmark, of_observations[i]->T_kf_w, camera))
        impossible.emplace_back(id, landmark.observations[i].keyframe_id);
    }
  }
  for (const auto& [id, keyframe_id] : impossible) DropObservation<Type>(id, keyframe_id, features, map);
}

}  // namespace

std::map<int64_t, SE3> PosesAfter(const std::vector<CorrectedPose>& corrected, const Map& map) {
  Poses named;
  for (const CorrectedPose& pose : corrected) named[pose.keyframe_id] = pose.T_w_kf;
  Poses poses;
  // Parents and predecessors are older, so each finds what carries it in its place.
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (const auto found = named.find(id); found != named.end()) {
      poses[id] = found->second;
      continue;
    }
    const auto carried = poses.find(CarrierOf(keyframe, named, poses));
    if (carried == poses.end()) continue;
    poses[id] = carried->second * (map.FindKeyframe(carried->first)->T_w_kf.Inverse() * keyframe.T_w_kf);
  }
  return poses;
}

void MoveKeyframes(const std::map<int64_t, SE3>& poses, const KeyframeFeatures& features, const StereoCamera& camera,
                   Map& map) {
  const std::map<int64_t, Moved> moves = MovesOf(poses, map);
  for (const auto& [id, move] : moves) {
    if (move.moves) map.SetPose(id, poses.at(id), map.FindKeyframe(id)->covariance);
  }
  MoveLandmarks<PointType>(moves, features, camera, map);
  MoveLandmarks<LineType>(moves, features, camera, map);
}

}  // namespace plslam
