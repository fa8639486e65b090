#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <set>

#include "core/localisation/pose_refinement.h"
#include "mapping_process/corrections/correction.h"
#include "mapping_process/corrections/map_parts.h"
#include "mapping_process/insertion/sight_error.h"
#include "mapping_process/mapper.h"

// How a keyframe finds its place in the map.

namespace plslam {
namespace {

// Associations below which a pose from the tracker is not corrected by them.
constexpr int kMinWeight = 20;
// Associations from which a keyframe is recognised wherever it is.
constexpr int kRecognisedWeight = 40;
// Squared error of the tracker's motion, in its deviations, that no motion has.
constexpr double kElsewhere2 = 400.0;

// How much two sources say of the same features, and differently; weights as of associations.
int Contradicting(const Association& a, const Association& b) {
  const auto differ = [](int64_t of_a, int64_t of_b) { return of_a >= 0 && of_b >= 0 && of_a != of_b ? 1 : 0; };
  return std::transform_reduce(a.points.begin(), a.points.end(), b.points.begin(), 0, std::plus<>(), differ) +
         2 * std::transform_reduce(a.lines.begin(), a.lines.end(), b.lines.begin(), 0, std::plus<>(), differ);
}

template <class Kind>
void DropFarOf(const Map& map, const std::vector<typename Kind::Feature>& features, const SE3& T_kf_w,
               const StereoCamera& camera, std::vector<int64_t>& association) {
  for (size_t i = 0; i < association.size(); ++i) {
    if (association[i] < 0) continue;
    const auto& landmark = *Kind::Find(map, association[i]);
    if (!IsNear(landmark, features[i], T_kf_w, camera)) association[i] = -1;
  }
}

// Claims that no pose confirms hold only where the landmark should appear near the feature.
void DropFar(const Map& map, const StereoFeatures& features, const SE3& T_w_kf, const StereoCamera& camera,
             Association& association) {
  const SE3 T_kf_w = T_w_kf.Inverse();
  DropFarOf<PointKind>(map, features.points, T_kf_w, camera, association.points);
  DropFarOf<LineKind>(map, features.lines, T_kf_w, camera, association.lines);
}

// The keyframe that sees most of the landmarks; there are some.
int64_t MostSeen(const Association& association, const Map& map) {
  std::map<int64_t, int> counts;
  CountKeyframes<PointKind>(association.points, map, counts);
  CountKeyframes<LineKind>(association.lines, map, counts);
  return MostCounted(counts, 1).front();
}

template <class Kind>
void ForgetGone(const Map& map, std::vector<int64_t>& ids) {
  for (int64_t& id : ids) {
    if (id >= 0 && Kind::Find(map, id) == nullptr) id = -1;
  }
}

}  // namespace

void Mapper::Join(const Keyframe& keyframe, MapKeyframe& entry, Association& association) {
  const bool begins = entry.previous_id < 0 && !map_.keyframes().empty();
  if (begins && association.Weight() < kMinWeight) Recognise(keyframe, entry, association);
  // First with what the tracker says, then with what can be found around it.
  Place(keyframe, entry, association);
  BringTogether(keyframe, association, entry);
  const LocalMap local = LocalMapOf(association, entry.previous_id, map_, options_.insertion.local_keyframes);
  SearchByProjection(map_, local, entry.T_w_kf, keyframe.features, camera_, options_.localisation, association);
  Refine(keyframe, entry, association);
}

bool Mapper::Refine(const Keyframe& keyframe, MapKeyframe& entry, Association& association) const {
  if (association.Weight() < kMinWeight) return false;
  const auto pose =
      RefinePose(map_, keyframe.features, camera_, entry.T_w_kf, options_.localisation.motion, association);
  if (pose) entry.T_w_kf = pose->T_w_kf;
  return pose.has_value();
}

// From where the keyframe should be, or from anywhere if most of what the tracker claims to see cannot be seen from there.
void Mapper::Place(const Keyframe& keyframe, MapKeyframe& entry, Association& association) {
  const Association given = TrackerLandmarks::Given(keyframe, map_);
  if (Contradicting(given, association) >= kRecognisedWeight) {
    Association there = given;
    MapKeyframe unused = entry;
    const bool agrees = Refine(keyframe, unused, there) && 2 * there.Weight() >= given.Weight();
    if (!agrees && Relocate(keyframe, given, entry, association)) return;
  }
  const Association claims = association;
  const bool agrees = Refine(keyframe, entry, association) && 2 * association.Weight() >= claims.Weight();
  if (agrees || Relocate(keyframe, claims, entry, association)) return;
  DropFar(map_, keyframe.features, entry.T_w_kf, camera_, association);
}

bool Mapper::Relocate(const Keyframe& keyframe, const Association& claims, MapKeyframe& entry,
                      Association& association) {
  if (claims.Weight() < kRecognisedWeight) return false;
  Association found = claims;
  const auto pose =
      FindPose(map_, keyframe.features, camera_, options_.localisation.motion, (claims.Weight() + 1) / 2, found);
  if (!pose) return false;
  association = found;
  const MapKeyframe& seen = *map_.FindKeyframe(MostSeen(association, map_));
  entry.T_w_kf = pose->T_w_kf;
  entry.covariance = ComposeCovariance(seen.covariance, seen.T_w_kf.Inverse() * pose->T_w_kf, pose->covariance);
  return true;
}

// The landmarks are of a part of the map that nothing has tied to the keyframe before: it lies elsewhere than the tracker's
// motion says, which is right as long as the tracker was not lost.
void Mapper::BringTogether(const Keyframe& keyframe, Association& association, MapKeyframe& entry) {
  if (entry.previous_id < 0 || keyframe.state == kRecovered || association.Weight() < kMinWeight) return;
  const SE3 T_w_predicted = map_.FindKeyframe(entry.previous_id)->T_w_kf * entry.T_prevkf_kf;
  const Vector6d error = (T_w_predicted.Inverse() * entry.T_w_kf).Log();
  if (error.dot(entry.relative_covariance.ldlt().solve(error)) < kElsewhere2) return;
  const std::set<int64_t> own = PartOf(entry.previous_id, map_);
  const int64_t seen_id = MostSeen(association, map_);
  if (own.contains(seen_id)) return;
  const std::set<int64_t> seen = PartOf(seen_id, map_);
  const bool own_moves = *own.begin() > *seen.begin();
  const SE3 T_w_fixed = own_moves ? entry.T_w_kf : T_w_predicted;
  const SE3 T_w_moving = own_moves ? T_w_predicted : entry.T_w_kf;
  std::map<int64_t, SE3> poses;
  for (const int64_t id : own_moves ? own : seen) {
    poses[id] = T_w_fixed * (T_w_moving.Inverse() * map_.FindKeyframe(id)->T_w_kf);
  }
  MoveKeyframes(poses, features_, camera_, map_);
  bent_version_ = version_ + 1;
  entry.T_w_kf = T_w_fixed;
  // A landmark goes when the move leaves it no sight that can be.
  ForgetGone<PointKind>(map_, association.points);
  ForgetGone<LineKind>(map_, association.lines);
}

void Mapper::Recognise(const Keyframe& keyframe, MapKeyframe& entry, Association& association) const {
  const MapKeyframe& newest = map_.keyframes().rbegin()->second;
  const LocalMap local = LocalMapOf({}, newest.id, map_, options_.insertion.local_keyframes);
  const auto pose =
      RecognisePose(map_, local, keyframe.features, camera_, options_.localisation, kRecognisedWeight, association);
  if (!pose) return;
  entry.T_w_kf = pose->T_w_kf;
  entry.covariance = ComposeCovariance(newest.covariance, newest.T_w_kf.Inverse() * pose->T_w_kf, pose->covariance);
}

}  // namespace plslam
