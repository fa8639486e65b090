// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/loop_verification.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/geometry/angle.h"
#include "core/geometry/hypot.h"
#include "core/geometry/symmetric.h"

namespace plslam::loop {
namespace {

// The paper's gates (§VI.A.2).
constexpr double kPaperEigenvalue = 0.01;
constexpr double kPaperMove_m = 0.5;
constexpr double kPaperTurn_rad = 3.0 * kRadPerDeg;
constexpr double kPaperInlierShare = 0.5;

// Sigmas by which two verticals may differ: those of real sensors are off by up to four (docs/lab/imu.md).
constexpr double kMostTilt = 6.0;

double Turn_rad(const SE3& T) { return T.Log().tail<3>().norm(); }

double LargestEigenvalue(const Matrix6d& covariance) { return EigenOf<6>(covariance).values(5); }

Matrix6d Isotropic(double sigma_m, double sigma_rad) {
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
  covariance.diagonal().tail<3>().setConstant(sigma_rad * sigma_rad);
  return covariance;
}

// Whether no keyframe sees both: two landmarks in one image are distinct.
template <class Landmark>
bool MayBeOne(const Landmark& a, const Landmark& b) {
  return std::none_of(a.observations.begin(), a.observations.end(),
                      [&b](const Observation& observation) { return IsSeenBy(b, observation.keyframe_id()); });
}

// Pairs of landmarks seen by one feature from both sides; each landmark at most once, the first pair wins.
template <class Type>
class Pairs {
 public:
  explicit Pairs(const Map& map) : map_(map) {}

  void Add(LandmarkId a, LandmarkId b) {
    if (a < 0 || b < 0 || a == b || taken_a_.contains(a) || taken_b_.contains(b)) return;
    if (!MayBeOne(*Type::Find(map_, a), *Type::Find(map_, b))) return;
    taken_a_.insert(a);
    taken_b_.insert(b);
    pairs_.push_back({a, b});
  }
  // Keeps only the first pair of a chain a-b, b-c.
  std::vector<SameLandmarks> Take() {
    std::erase_if(pairs_, [this](const SameLandmarks& pair) { return taken_b_.contains(pair.a); });
    return std::move(pairs_);
  }

 private:
  const Map& map_;
  std::vector<SameLandmarks> pairs_;
  std::set<LandmarkId> taken_a_;
  std::set<LandmarkId> taken_b_;
};

class Verification {
 public:
  Verification(const Map& map, const KeyframeMemory& memory, const StereoCamera& camera, const LoopOptions& options,
               MapPaths& paths, KeyframeId old_id, KeyframeId id)
      : map_(map),
        memory_(memory),
        camera_(camera),
        options_(options),
        gates_(options.verification),
        paths_(paths),
        old_(*map.FindKeyframe(old_id)),
        keyframe_(*map.FindKeyframe(id)),
        old_place_(PlaceAround(map, old_id, options.verification.local_keyframes)) {}

  LoopEvidence Run();

 private:
  DescribedImage ImageOf(KeyframeId id) const { return {memory_.features().at(id), memory_.point_nodes().at(id)}; }
  void Measure(const KeyframePose& pose);
  bool Guess();
  bool Find();
  bool PassesPaperGates() const;
  bool HasInliers() const;
  bool IsSeenFromOldSide();
  void AskKeyframesBefore();
  int NeededConfirmations() const;
  bool IsWithinDrift();
  bool IsUpright() const;
  bool Agree(const SE3& predicted, const SE3& found) const;
  template <class Type>
  std::vector<SameLandmarks> PairUp(const std::vector<LandmarkId>& seen_now,
                                    const std::vector<LandmarkId>& seen_then) const;

  const Map& map_;
  const KeyframeMemory& memory_;
  const StereoCamera& camera_;
  const LoopOptions& options_;
  const VerificationOptions& gates_;
  MapPaths& paths_;
  const MapKeyframe& old_;
  const MapKeyframe& keyframe_;
  Place old_place_;
  LoopEvidence evidence_;
};

void Verification::Measure(const KeyframePose& pose) {
  evidence_.edge.T_old_kf = old_.T_w_kf.Inverse() * pose.T_w_kf;
  evidence_.edge.covariance =
      pose.covariance + Isotropic(options_.correction.loop_sigma_m, options_.correction.loop_sigma_deg * kRadPerDeg);
}

bool Verification::Guess() {
  const auto pose = GuessPose(map_, old_.id, ImageOf(old_.id), ImageOf(keyframe_.id), camera_, options_.localisation,
                              gates_.min_matches);
  if (pose) Measure(*pose);
  return pose.has_value();
}

bool Verification::Find() {
  const auto place = FindPlace(map_, old_place_, old_.T_w_kf * evidence_.edge.T_old_kf,
                               memory_.features().at(keyframe_.id), camera_, options_.localisation);
  if (!place) return false;
  Measure(place->pose);
  evidence_.place = *place;
  evidence_.confirming = 1;
  const auto count = [](const std::vector<LandmarkId>& ids) {
    return static_cast<int32_t>(std::count_if(ids.begin(), ids.end(), [](LandmarkId id) { return id >= 0; }));
  };
  evidence_.edge.n_points = count(place->association.points);
  evidence_.edge.n_lines = count(place->association.lines);
  return true;
}

bool Verification::PassesPaperGates() const {
  const FoundPlace& place = evidence_.place;
  const SE3& T = evidence_.edge.T_old_kf;
  return LargestEigenvalue(place.pose.covariance) < kPaperEigenvalue && T.translation().norm() <= kPaperMove_m &&
         Turn_rad(T) <= kPaperTurn_rad && place.inliers > kPaperInlierShare * place.matches;
}

bool Verification::HasInliers() const {
  const FoundPlace& place = evidence_.place;
  return place.inliers >= gates_.min_inliers && place.cells >= gates_.min_cells &&
         place.landmarks.Share() >=
             (evidence_.connected ? gates_.min_inlier_share : gates_.min_inlier_share_unconnected) &&
         LargestEigenvalue(place.pose.covariance) <= gates_.max_eigenvalue;
}

bool Verification::Agree(const SE3& predicted, const SE3& found) const {
  const SE3 apart = predicted.Inverse() * found;
  const double distance_m = std::max(kNearestScale_m, evidence_.place.median_depth_m);
  return apart.translation().norm() <= gates_.max_disagreement * distance_m &&
         Turn_rad(apart) <= gates_.max_disagreement_deg * kRadPerDeg;
}

bool Verification::IsSeenFromOldSide() {
  // Pose of the old keyframe relative to the map around the new one, as the loop predicts it.
  const SE3 T_w_old = keyframe_.T_w_kf * evidence_.edge.T_old_kf.Inverse();
  const auto place = FindPlace(map_, PlaceAround(map_, keyframe_.id, gates_.local_keyframes), T_w_old,
                               memory_.features().at(old_.id), camera_, options_.localisation);
  Association then;
  if (place) {
    evidence_.reverse_inliers = place->inliers;
    then = place->association;
  }
  evidence_.points = PairUp<PointType>(evidence_.place.association.points, then.points);
  evidence_.lines = PairUp<LineType>(evidence_.place.association.lines, then.lines);
  return place && place->inliers >= gates_.min_reverse_inliers && Agree(T_w_old, place->pose.T_w_kf);
}

template <class Type>
std::vector<SameLandmarks> Verification::PairUp(const std::vector<LandmarkId>& seen_now,
                                                const std::vector<LandmarkId>& seen_then) const {
  Pairs<Type> pairs(map_);
  for (int32_t i = 0; i < static_cast<int32_t>(seen_now.size()); ++i) {
    pairs.Add(seen_now[static_cast<size_t>(i)], LandmarkAt<Type>(map_, {keyframe_.id, i}));
  }
  for (int32_t i = 0; i < static_cast<int32_t>(seen_then.size()); ++i) {
    pairs.Add(LandmarkAt<Type>(map_, {old_.id, i}), seen_then[static_cast<size_t>(i)]);
  }
  return pairs.Take();
}

void Verification::AskKeyframesBefore() {
  const MapKeyframe* before = map_.FindKeyframe(keyframe_.previous_id);
  while (before != nullptr && evidence_.confirming < gates_.consistent_keyframes) {
    const auto features = memory_.features().find(before->id);
    if (features == memory_.features().end()) return;
    const SE3 predicted = evidence_.place.pose.T_w_kf * (keyframe_.T_w_kf.Inverse() * before->T_w_kf);
    const auto place = FindPlace(map_, old_place_, predicted, features->second, camera_, options_.localisation);
    if (!place || place->inliers < gates_.min_neighbour_inliers || !Agree(predicted, place->pose.T_w_kf)) return;
    ++evidence_.confirming;
    before = map_.FindKeyframe(before->previous_id);
  }
}

int Verification::NeededConfirmations() const {
  // Without a path there is no expected drift that could separate two places of the same appearance.
  if (!evidence_.connected) return gates_.consistent_keyframes;
  const int spared = evidence_.place.inliers / std::max(1, gates_.strong_inliers);
  return std::max(1, gates_.consistent_keyframes - std::min(2, spared));
}

bool Verification::IsWithinDrift() {
  const auto path = paths_.From(old_.id);
  evidence_.connected = path.has_value();
  if (!path) return true;
  const double turn_rad = gates_.drift_deg_per_m * kRadPerDeg * path->length_m;
  const double move_m = gates_.drift_per_m * path->length_m + turn_rad * path->reach_m;
  const Matrix6d least = Isotropic(move_m, turn_rad) + evidence_.edge.covariance;
  const SE3 T_old_kf = old_.T_w_kf.Inverse() * keyframe_.T_w_kf;
  const Vector6d correction = (T_old_kf.Inverse() * evidence_.edge.T_old_kf).Log();
  const auto chi2 = [&](const Matrix6d& covariance) { return SquaredMahalanobis<6>(correction, covariance); };
  evidence_.drift_chi2 = chi2(least);
  if (evidence_.drift_chi2 <= gates_.max_drift_chi2) return true;
  // The covariance of the path can only lower it; it is computed last because its cost grows with the path.
  const double scale = gates_.covariance_scale * gates_.covariance_scale;
  evidence_.drift_chi2 = chi2(least + scale * paths_.CovarianceFrom(old_.id));
  return evidence_.drift_chi2 <= gates_.max_drift_chi2;
}

/// Compares the verticals of both keyframes, if an inertial sensor measured them.
bool Verification::IsUpright() const {
  if (!old_.up || !keyframe_.up) return true;
  const Eigen::Vector3d up_old = evidence_.edge.T_old_kf.rotation() * keyframe_.up->direction;
  const double angle_rad = AngleBetween(up_old, old_.up->direction);
  const double loop_rad = std::sqrt(evidence_.edge.covariance.diagonal().tail<3>().maxCoeff());
  const double sigma_rad = Hypot(Hypot(old_.up->sigma_rad, keyframe_.up->sigma_rad), loop_rad);
  return angle_rad <= kMostTilt * sigma_rad;
}

LoopEvidence Verification::Run() {
  evidence_.edge.old_keyframe_id = old_.id;
  evidence_.edge.keyframe_id = keyframe_.id;
  const auto conclude = [this](LoopVerdict verdict) {
    evidence_.verdict = verdict;
    return evidence_;
  };
  const bool paper = gates_.gates == LoopGates::kPaper;
  if (!Guess()) return conclude(LoopVerdict::kNotFound);
  if (!IsWithinDrift() && !paper) return conclude(LoopVerdict::kBeyondDrift);
  if (!Find()) return conclude(LoopVerdict::kNotFound);
  if (paper ? !PassesPaperGates() : !HasInliers()) {
    return conclude(paper ? LoopVerdict::kPaperGates : LoopVerdict::kFewInliers);
  }
  if (!paper && !IsUpright()) return conclude(LoopVerdict::kTilted);
  const bool both_sides = IsSeenFromOldSide();
  if (paper) return conclude(LoopVerdict::kAccepted);
  if (!both_sides) return conclude(LoopVerdict::kOneSided);
  if (!IsWithinDrift()) return conclude(LoopVerdict::kBeyondDrift);
  AskKeyframesBefore();
  return conclude(evidence_.confirming >= NeededConfirmations() ? LoopVerdict::kAccepted : LoopVerdict::kUnconfirmed);
}

}  // namespace

const char* LoopVerdictName(LoopVerdict verdict) {
  switch (verdict) {
    case LoopVerdict::kAccepted:
      return "accepted";
    case LoopVerdict::kNotFound:
      return "not found";
    case LoopVerdict::kFewInliers:
      return "few inliers";
    case LoopVerdict::kOneSided:
      return "one-sided";
    case LoopVerdict::kUnconfirmed:
      return "unconfirmed";
    case LoopVerdict::kTilted:
      return "tilted";
    case LoopVerdict::kBeyondDrift:
      return "beyond drift";
    case LoopVerdict::kPaperGates:
      break;
  }
  return "paper's gates";
}

LoopEvidence VerifyLoop(const Map& map, const KeyframeMemory& memory, const StereoCamera& camera,
                        const LoopOptions& options, MapPaths& paths, KeyframeId old_keyframe_id,
                        KeyframeId keyframe_id) {
  const bool known = map.FindKeyframe(old_keyframe_id) != nullptr && map.FindKeyframe(keyframe_id) != nullptr &&
                     memory.places().Has(old_keyframe_id) && memory.places().Has(keyframe_id);
  if (!known) return {};
  return Verification(map, memory, camera, options, paths, old_keyframe_id, keyframe_id).Run();
}

}  // namespace plslam::loop
