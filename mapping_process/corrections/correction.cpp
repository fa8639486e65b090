// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/corrections/correction.h"

#include <algorithm>
#include <utility>

#include "mapping_process/insertion/observations.h"

namespace plslam::mapping {
namespace {

// Keyframes of those that see a landmark with which it is tried to move; they are spread over its life.
constexpr size_t kTried = 4;
// Growth of a landmark's error, in squared standard deviations over all its observations, that is nothing beside the
// noise which the error is made of.
constexpr double kUnnoticed = 1.0;

using Poses = std::map<int64_t, SE3>;

// A keyframe before and after a correction.
struct Moved {
  SE3 T_new_old;  // of w
  SE3 T_kf_old_w;
  SE3 T_kf_w;
  bool moves = false;
};
using Moves = IdMap<Moved>;

int64_t CarrierOf(const MapKeyframe& keyframe, const Poses& named, const Poses& poses) {
  for (const Poses* found : {&named, &poses}) {
    for (const int64_t id : {keyframe.parent_id, keyframe.previous_id}) {
      if (found->contains(id)) return id;
    }
  }
  return -1;
}

Moves MovesOf(const Poses& poses, const Map& map) {
  Moves moves;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const auto pose = poses.find(id);
    const SE3 T_kf_w = keyframe.T_w_kf.Inverse();
    if (pose == poses.end()) {
      moves[id] = {SE3(), T_kf_w, T_kf_w, false};
    } else {
      moves[id] = {pose->second * T_kf_w, T_kf_w, pose->second.Inverse(), true};
    }
  }
  return moves;
}

MapPoint PlaceOf(const MapPoint& point) {
  MapPoint place;
  place.p_w = point.p_w;
  place.covariance = point.covariance;
  return place;
}

MapLine PlaceOf(const MapLine& line) {
  MapLine place;
  place.segment_w = line.segment_w;
  place.covariance_p = line.covariance_p;
  place.covariance_q = line.covariance_q;
  return place;
}

void Place(int64_t id, const MapPoint& place, Map& map) { map.SetPosition(id, place.p_w, place.covariance); }
void Place(int64_t id, const MapLine& place, Map& map) {
  map.SetSegment(id, place.segment_w, place.covariance_p, place.covariance_q);
}

// How the keyframes that see a landmark move.
std::vector<const Moved*> MovesOfObservations(const std::vector<Observation>& observations, const Moves& moves) {
  std::vector<const Moved*> of_observations;
  of_observations.reserve(observations.size());
  for (const Observation& observation : observations) of_observations.push_back(&moves.at(observation.keyframe_id));
  return of_observations;
}

// The landmarks of one feature type in a correction.
template <class Type>
class Corrected {
 public:
  Corrected(const Moves& moves, const KeyframeFeatures& features, const StereoCamera& camera, Map& map)
      : moves_(moves), features_(features), camera_(camera), map_(map) {
    for (const auto& [id, landmark] : Type::Landmarks(map)) {
      // What only one keyframe sees goes with it, and nothing changes.
      if (landmark.observations.size() < 2) continue;
      const auto of_observations = MovesOfObservations(landmark.observations, moves);
      const auto moved = [](const Moved* move) { return move->moves; };
      if (std::none_of(of_observations.begin(), of_observations.end(), moved)) continue;
      before_.push_back(
          {id, PlaceOf(landmark), ErrorAt(landmark, landmark.observations, of_observations, &Moved::T_kf_old_w)});
    }
  }

  // After the map has been moved: what is seen worse than before goes where it is seen best. Returns which.
  std::vector<int64_t> PlaceWhatIsSeenWorse() {
    std::vector<int64_t> worse;
    std::vector<std::pair<int64_t, int64_t>> impossible;
    for (const auto& [id, place, error] : before_) {
      const Landmark& landmark = *Type::Find(map_, id);
      const auto of_observations = MovesOfObservations(landmark.observations, moves_);
      if (ErrorAt(landmark, landmark.observations, of_observations, &Moved::T_kf_w) > error + kUnnoticed) {
        worse.push_back(id);
        Place(id, BestPlace(landmark, place, of_observations), map_);
      }
      for (size_t i = 0; i < of_observations.size(); ++i) {
        if (IsBehind(landmark, of_observations[i]->T_kf_w, camera_))
          impossible.emplace_back(id, landmark.observations[i].keyframe_id);
      }
    }
    for (const auto& [id, keyframe_id] : impossible) DropObservation<Type>(id, keyframe_id, features_, map_);
    std::erase_if(worse, [this](int64_t id) { return Type::Find(map_, id) == nullptr; });
    return worse;
  }

 private:
  using Landmark = typename Type::Landmark;
  struct Before {
    int64_t id = -1;
    Landmark place;
    double error = 0.0;
  };

  double ErrorAt(const Landmark& place, const std::vector<Observation>& observations,
                 const std::vector<const Moved*>& moves, SE3 Moved::*T_kf_w) const {
    double sum = 0.0;
    for (size_t i = 0; i < observations.size(); ++i) {
      const auto& seen =
          Type::Features(features_.at(observations[i].keyframe_id))[static_cast<size_t>(observations[i].feature)];
      sum += ObservationError(place, seen, moves[i]->*T_kf_w, camera_);
    }
    return sum;
  }

  // Where it is, or where one of those that see it would have taken it; the newest of equals.
  Landmark BestPlace(const Landmark& now, const Landmark& before, const std::vector<const Moved*>& moves) const {
    const size_t tried = std::min(moves.size(), kTried);
    Landmark best = now;
    double least = ErrorAt(now, now.observations, moves, &Moved::T_kf_w);
    for (size_t i = 0; i < tried; ++i) {
      Landmark place = before;
      MoveRigidly(moves[i * (moves.size() - 1) / (tried - 1)]->T_new_old, place);
      const double error = ErrorAt(place, now.observations, moves, &Moved::T_kf_w);
      if (error > least) continue;
      best = place;
      least = error;
    }
    return best;
  }

  const Moves& moves_;
  const KeyframeFeatures& features_;
  const StereoCamera& camera_;
  Map& map_;
  std::vector<Before> before_;
};

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

LandmarksNamed MoveKeyframes(const std::map<int64_t, SE3>& poses, const KeyframeFeatures& features,
                             const StereoCamera& camera, Map& map) {
  const Moves moves = MovesOf(poses, map);
  Corrected<PointType> points(moves, features, camera, map);
  Corrected<LineType> lines(moves, features, camera, map);
  map.Move(poses);
  return {points.PlaceWhatIsSeenWorse(), lines.PlaceWhatIsSeenWorse()};
}

}  // namespace plslam::mapping
