// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Cholesky>

#include "core/optim/bundle/adjusted_observation.h"
#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/camera_view.h"
#include "core/optim/bundle/step_control.h"

namespace plslam {

inline int LandmarkOf(const PointObservation& observation) { return observation.point; }
inline int LandmarkOf(const LineObservation& observation) { return observation.line; }

/// Sums over observations that are inliers.
struct ObservationSums {
  double squares = 0.0;
  double rows = 0.0;
  double squares_px = 0.0;
  double observations = 0.0;
};

/// Where observations are looked at: as the adjustment was given, or as it was evaluated last.
enum class State { kStart, kNow };

/// All landmarks of one feature type and their observations, in the order of the landmarks. Points and lines are two
/// of these.
template <class Cost>
class ObservationGroup {
 public:
  using Landmark = typename Cost::Landmark;
  static constexpr int kSize = Landmark::kSize;
  using Information = Eigen::Matrix<double, kSize, kSize>;

  /// Observations that cannot be measured (not finite, of landmarks that are not) take no part, now or later; those
  /// that the landmark is behind of take none until a gate lets them in.
  template <class GivenLandmark, class Observation>
  ObservationGroup(const std::vector<GivenLandmark>& landmarks, const std::vector<Observation>& observations,
                   double huber_delta, std::vector<AdjustedPose>& poses, const StereoCamera& camera);

  /// Gives weak priors to the free landmarks that their observations do not determine (at infinity, seen once without
  /// disparity, along a line). They hold them near their start, and are nothing beside what is measured.
  void HoldUndetermined();

  /// Twice the cost of the observations that take part, and their rows, as they were evaluated last.
  LossSum Loss() const;

  /// Twice the cost of the weak priors.
  double PriorLoss() const;

  /// Takes away what stands out far from the landmark's other observations: it would pull the first step astray.
  void TrimGross();

  /// Takes away those that do not agree as they were evaluated last, where most of the landmark's observations do:
  /// others are not yet where that can be told.
  void Trim(const Gates& gates);

  /// Lets those take part that agree with the state as it is; returns how many changed.
  int Gate(const Gates& gates);

  /// Puts back where they were the landmarks that no observation agrees with.
  void RestoreLost();

  /// Says of the poses that an observation agrees with that they are constant.
  void HoldPoses();

  ObservationSums Sum(State state) const;
  /// In the order of the observations given.
  std::vector<bool> Inliers() const;
  bool IsFinite() const;
  /// Any free landmark that is seen.
  bool HasFree() const { return has_free_; }

  /// Calls `visit(landmark index, first, last)` for each landmark with its range of `observations()`.
  template <class Visitor>
  void ForEachLandmark(Visitor visit) const {
    for (size_t i = 0; i < landmarks_.size(); ++i)
      visit(i, observations_.data() + first_[i], observations_.data() + first_[i + 1]);
  }

  const std::vector<Landmark>& landmarks() const { return landmarks_; }
  std::vector<Landmark>& landmarks() { return landmarks_; }
  int observation_count() const { return first_.back(); }
  double huber_delta() const { return huber_delta_; }
  bool HasPrior(size_t landmark) const { return !prior_weights_[landmark].isZero(0.0); }
  /// Root of the information of a landmark's weak prior, symmetric; zero where there is none.
  const Information& PriorWeight(size_t landmark) const { return prior_weights_[landmark]; }
  Information PriorInformation(size_t landmark) const { return prior_weights_[landmark] * prior_weights_[landmark]; }

 private:
  int Count(size_t landmark) const { return first_[landmark + 1] - first_[landmark]; }
  double DistanceTo(size_t landmark) const;
  Information InformationOf(size_t landmark) const;
  bool IsDetermined(size_t landmark, double distance_m) const;
  /// After a change: a landmark that its observations do not determine any more, and no prior holds, takes no part.
  void DropUndetermined(size_t landmark);

  double huber_delta_;
  std::vector<Landmark> landmarks_;
  /// Observations of landmark i are first_[i] to first_[i + 1].
  std::vector<int> first_;
  std::vector<AdjustedObservation<Cost>> observations_;
  size_t given_observations_;
  std::vector<Information> prior_weights_;
  bool has_free_ = false;
};

}  // namespace plslam

#include "core/optim/bundle/observation_group_impl.h"
