// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/corrections/correction.h"

#include <algorithm>
#include <future>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "mapping_process/insertion/observations.h"

namespace plslam::mapping {
namespace {

// Number of observing keyframes, spread over its observations, with each of which a landmark is moved in trial.
constexpr size_t kTried = 4;
// Growth of a landmark's error, in squared standard deviations summed over its observations, that is negligible
// compared to measurement noise.
constexpr double kUnnoticed = 1.0;

using Poses = std::map<KeyframeId, SE3>;

// A keyframe before and after a correction.
struct Moved {
  const KeptFeatures* features = nullptr;
  SE3 T_new_old;  // displacement in the map frame
  SE3 T_kf_old_w;
  SE3 T_kf_w;
  bool moves = false;
};
using Moves = IdMap<KeyframeId, Moved>;

KeyframeId CarrierOf(const MapKeyframe& keyframe, const Poses& named, const Poses& poses) {
  for (const Poses* found : {&named, &poses}) {
    for (const KeyframeId id : {keyframe.parent_id, keyframe.previous_id}) {
      if (found->contains(id)) return id;
    }
  }
  return -1;
}

Moves MovesOf(const Poses& poses, const KeyframeFeatures& features, const Map& map) {
  Moves moves;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const auto pose = poses.find(id);
    const KeptFeatures* of_keyframe = &features.at(id);
    const SE3 T_kf_w = keyframe.T_w_kf.Inverse();
    if (pose == poses.end()) {
      moves[id] = {of_keyframe, SE3(), T_kf_w, T_kf_w, false};
    } else {
      moves[id] = {of_keyframe, pose->second * T_kf_w, T_kf_w, pose->second.Inverse(), true};
    }
  }
  return moves;
}

MapPoint GeometryOf(const MapPoint& point) {
  MapPoint place;
  place.p_w = point.p_w;
  place.covariance = point.covariance;
  return place;
}

MapLine GeometryOf(const MapLine& line) {
  MapLine place;
  place.segment_w = line.segment_w;
  place.covariance_p = line.covariance_p;
  place.covariance_q = line.covariance_q;
  return place;
}

void Place(LandmarkId id, const MapPoint& place, Map& map) { map.SetPosition(id, place.p_w, place.covariance); }
void Place(LandmarkId id, const MapLine& place, Map& map) {
  map.SetSegment(id, place.segment_w, place.covariance_p, place.covariance_q);
}

// Calls visit(i) for each i below n, in any order, on several threads.
template <class Visit>
void ForEachOnAllProcessors(size_t n, const Visit& visit) {
  const size_t n_threads = std::clamp(std::thread::hardware_concurrency(), 1U, 8U);
  const auto visit_part = [&](size_t part) {
    for (size_t i = part * n / n_threads; i < (part + 1) * n / n_threads; ++i) visit(i);
  };
  std::vector<std::future<void>> others;
  for (size_t part = 1; part < n_threads; ++part) others.push_back(std::async(std::launch::async, visit_part, part));
  visit_part(0);
  for (std::future<void>& other : others) other.get();
}

// Displacements of the keyframes that observe a landmark.
std::vector<const Moved*> MovesOfObservations(const std::vector<Observation>& observations, const Moves& moves) {
  std::vector<const Moved*> of_observations;
  of_observations.reserve(observations.size());
  for (const Observation& observation : observations) of_observations.push_back(&moves.at(observation.keyframe_id()));
  return of_observations;
}

// The landmarks of one feature type in a correction.
template <class Type>
class Corrected {
 public:
  Corrected(const Moves& moves, const KeyframeFeatures& features, const StereoCamera& camera, Map& map)
      : moves_(moves), features_(features), camera_(camera), map_(map) {
    std::vector<const Landmark*> landmarks;
    landmarks.reserve(Type::Landmarks(map).size());
    const auto moved = [&moves](const Observation& observation) { return moves.at(observation.keyframe_id()).moves; };
    for (const auto& [id, landmark] : Type::Landmarks(map)) {
      // A landmark with one observation moves with its keyframe: its error does not change.
      if (landmark.observations.size() < 2) continue;
      if (std::any_of(landmark.observations.begin(), landmark.observations.end(), moved))
        landmarks.push_back(&landmark);
    }
    before_.resize(landmarks.size());
    ForEachOnAllProcessors(landmarks.size(), [&](size_t i) {
      const Landmark& landmark = *landmarks[i];
      before_[i] = {landmark.id, GeometryOf(landmark),
                    ErrorAt(landmark, landmark.observations, MovesOfObservations(landmark.observations, moves),
                            &Moved::T_kf_old_w)};
    });
  }

  // Called after the map has moved: places landmarks whose error has grown where it is least. Returns their ids.
  std::vector<LandmarkId> RepositionDegraded() {
    std::vector<std::optional<Landmark>> better(before_.size());
    std::vector<std::vector<KeyframeId>> impossible(before_.size());
    ForEachOnAllProcessors(before_.size(), [&](size_t i) {
      const auto& [id, place, error] = before_[i];
      const Landmark& landmark = *Type::Find(map_, id);
      const auto of_observations = MovesOfObservations(landmark.observations, moves_);
      if (ErrorAt(landmark, landmark.observations, of_observations, &Moved::T_kf_w) > error + kUnnoticed)
        better[i] = BestPlace(landmark, place, of_observations);
      const Landmark& now = better[i] ? *better[i] : landmark;
      for (size_t k = 0; k < of_observations.size(); ++k) {
        if (IsBehind(now, of_observations[k]->T_kf_w, camera_))
          impossible[i].push_back(landmark.observations[k].keyframe_id());
      }
    });
    std::vector<LandmarkId> worse;
    for (size_t i = 0; i < before_.size(); ++i) {
      if (!better[i]) continue;
      worse.push_back(before_[i].id);
      Place(before_[i].id, *better[i], map_);
    }
    for (size_t i = 0; i < before_.size(); ++i) {
      for (const KeyframeId keyframe_id : impossible[i])
        DropObservation<Type>(before_[i].id, keyframe_id, features_, map_);
    }
    std::erase_if(worse, [this](LandmarkId id) { return Type::Find(map_, id) == nullptr; });
    return worse;
  }

 private:
  using Landmark = typename Type::Landmark;
  struct Before {
    LandmarkId id = -1;
    Landmark place;
    double error = 0.0;
  };

  double ErrorAt(const Landmark& place, const std::vector<Observation>& observations,
                 const std::vector<const Moved*>& moves, SE3 Moved::*T_kf_w) const {
    double sum = 0.0;
    for (size_t i = 0; i < observations.size(); ++i) {
      const auto& seen = Type::Features(*moves[i]->features)[static_cast<size_t>(observations[i].feature)];
      sum += ObservationError(place, seen, moves[i]->*T_kf_w, camera_);
    }
    return sum;
  }

  // Chooses between the current position and those of moving rigidly with one of the observers, by the summed squared
  // error; the newest of equal ones.
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

std::map<KeyframeId, SE3> PosesAfter(const std::vector<CorrectedPose>& corrected, const Map& map) {
  Poses named;
  for (const CorrectedPose& pose : corrected) named[pose.keyframe_id] = pose.T_w_kf;
  Poses poses;
  // Parents and predecessors are older, so their poses are known here.
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

LandmarksNamed MoveKeyframes(const std::map<KeyframeId, SE3>& poses, const KeyframeFeatures& features,
                             const StereoCamera& camera, Map& map) {
  const Moves moves = MovesOf(poses, features, map);
  Corrected<PointType> points(moves, features, camera, map);
  Corrected<LineType> lines(moves, features, camera, map);
  map.Move(poses);
  return {points.RepositionDegraded(), lines.RepositionDegraded()};
}

}  // namespace plslam::mapping
