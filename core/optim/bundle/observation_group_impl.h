// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/geometry/symmetric.h"
#include "core/optim/bundle/observation_group.h"

namespace plslam {

template <class Cost>
template <class GivenLandmark, class Observation>
ObservationGroup<Cost>::ObservationGroup(const std::vector<GivenLandmark>& landmarks,
                                         const std::vector<Observation>& observations, double huber_delta,
                                         std::vector<AdjustedPose>& poses, const StereoCamera& camera)
    : huber_delta_(huber_delta),
      landmarks_(landmarks.begin(), landmarks.end()),
      first_(landmarks.size() + 1, 0),
      given_observations_(observations.size()),
      prior_weights_(landmarks.size(), Information::Zero()) {
  std::vector<char> usable(observations.size());
  for (size_t i = 0; i < observations.size(); ++i) {
    const int landmark = LandmarkOf(observations[i]);
    usable[i] = Cost::IsUsable(observations[i]) && landmarks_[landmark].IsUsable();
    if (usable[i]) ++first_[landmark + 1];
  }
  for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  observations_.resize(first_.back());
  std::vector<int> next(first_);
  for (size_t i = 0; i < observations.size(); ++i) {
    if (!usable[i]) continue;
    Landmark& landmark = landmarks_[LandmarkOf(observations[i])];
    AdjustedPose& pose = poses[observations[i].pose];
    ++pose.observations;
    observations_[next[LandmarkOf(observations[i])]++].Bind(Cost(observations[i], landmark, pose.view, camera), pose,
                                                            landmark, static_cast<int>(i));
  }
  for (size_t i = 0; i < landmarks_.size(); ++i) has_free_ |= landmarks_[i].free && Count(i) > 0;
}

template <class Cost>
void ObservationGroup<Cost>::TrimGross() {
  // Limit on squared norms: five times the median norm, and at least ten standard deviations.
  constexpr double kMedians = 25.0;
  constexpr double kFloor = 100.0;
  std::vector<double> squares;
  for (size_t i = 0; i < landmarks_.size(); ++i) {
    squares.clear();
    for (int k = first_[i]; k < first_[i + 1]; ++k) {
      if (observations_[k].active) squares.push_back(observations_[k].now.squared);
    }
    const double largest = std::max(kFloor, kMedians * Median(squares));
    for (int k = first_[i]; k < first_[i + 1]; ++k)
      observations_[k].active &= observations_[k].now.squared <= largest;
  }
}

template <class Cost>
typename ObservationGroup<Cost>::Information ObservationGroup<Cost>::InformationOf(size_t landmark) const {
  Information sum = Information::Zero();
  double r[Cost::kMaxRows];
  Eigen::Matrix<double, Cost::kMaxRows, kSize, Eigen::RowMajor> J;
  for (int i = first_[landmark]; i < first_[landmark + 1]; ++i) {
    const AdjustedObservation<Cost>& observation = observations_[i];
    J.setZero();
    if (observation.active &&
        observation.cost.Evaluate(observation.pose->view, landmarks_[landmark].x.data(), r, nullptr, J.data())) {
      sum.noalias() += J.transpose() * J;
    }
  }
  return sum;
}

template <class Cost>
double ObservationGroup<Cost>::DistanceTo(size_t landmark) const {
  constexpr double kMin_m = 1e-3;
  const Eigen::Vector3d middle_w = landmarks_[landmark].Middle();
  double nearest_m = std::numeric_limits<double>::max();
  for (int k = first_[landmark]; k < first_[landmark + 1]; ++k) {
    nearest_m = std::min(nearest_m, (middle_w - observations_[k].pose->view.t_w_c).norm());
  }
  return std::max(nearest_m, kMin_m);
}

template <class Cost>
bool ObservationGroup<Cost>::IsDetermined(size_t landmark, double distance_m) const {
  constexpr double kMaxRelativeSigma = 0.3;
  // Positive definite if the information exceeds that of the largest acceptable sigma.
  Information excess = InformationOf(landmark);
  excess.diagonal().array() -= 1.0 / std::pow(kMaxRelativeSigma * distance_m, 2);
  return IsPositiveDefinite<kSize>(excess);
}

template <class Cost>
void ObservationGroup<Cost>::HoldUndetermined() {
  for (size_t i = 0; i < landmarks_.size(); ++i) {
    const Landmark& landmark = landmarks_[i];
    if (!landmark.free || Count(i) == 0) continue;
    const double distance_m = DistanceTo(i);
    if (Landmark::kAlwaysPrior || !IsDetermined(i, distance_m)) prior_weights_[i] = landmark.PriorWeight(distance_m);
  }
}

template <class Cost>
LossSum ObservationGroup<Cost>::Loss() const {
  LossSum sum;
  for (int i = 0; i < first_.back(); ++i) {
    if (!observations_[i].active) continue;
    sum.loss += observations_[i].Loss(huber_delta_);
    sum.rows += observations_[i].cost.rows();
  }
  return sum;
}

template <class Cost>
double ObservationGroup<Cost>::PriorLoss() const {
  double loss = 0.0;
  for (size_t i = 0; i < landmarks_.size(); ++i) {
    if (HasPrior(i)) loss += (prior_weights_[i] * (landmarks_[i].x - landmarks_[i].start)).squaredNorm();
  }
  return loss;
}

template <class Cost>
void ObservationGroup<Cost>::Trim(const Gates& gates) {
  for (size_t i = 0; i < landmarks_.size(); ++i) {
    const auto begin = observations_.begin() + first_[i];
    const auto end = begin + Count(i);
    const auto taken = std::count_if(begin, end, [](const auto& observation) { return observation.active; });
    const auto good = std::count_if(begin, end, [&](const auto& s) { return s.active && s.Agrees(gates); });
    if (good == taken || 2 * good <= taken) continue;
    for (auto observation = begin; observation != end; ++observation)
      observation->active = observation->active && observation->Agrees(gates);
    DropUndetermined(i);
  }
}

template <class Cost>
int ObservationGroup<Cost>::Gate(const Gates& gates) {
  int changed = 0;
  std::vector<bool> before;
  for (size_t i = 0; i < landmarks_.size(); ++i) {
    const auto begin = observations_.begin() + first_[i];
    const auto end = begin + Count(i);
    before.clear();
    bool agree_as_before = true;
    for (auto observation = begin; observation != end; ++observation) {
      observation->cost.Anchor(observation->pose->view, landmarks_[i]);
      observation->Refit();
      before.push_back(std::exchange(observation->active, observation->Agrees(gates)));
      agree_as_before &= before.back() == observation->active;
    }
    if (agree_as_before) continue;
    DropUndetermined(i);
    // Observations deactivated before and again have not changed.
    for (int k = 0; k < Count(i); ++k) changed += begin[k].active != before[static_cast<size_t>(k)];
  }
  return changed;
}

template <class Cost>
void ObservationGroup<Cost>::DropUndetermined(size_t landmark) {
  if (!landmarks_[landmark].free || HasPrior(landmark) || IsDetermined(landmark, DistanceTo(landmark))) return;
  for (int k = first_[landmark]; k < first_[landmark + 1]; ++k) observations_[k].active = false;
}

template <class Cost>
void ObservationGroup<Cost>::RestoreLost() {
  for (size_t i = 0; i < landmarks_.size(); ++i) {
    const auto begin = observations_.begin() + first_[i];
    if (std::none_of(begin, begin + Count(i), [](const auto& observation) { return observation.active; })) {
      landmarks_[i].x = landmarks_[i].start;
    }
  }
}

template <class Cost>
void ObservationGroup<Cost>::HoldPoses() {
  for (AdjustedObservation<Cost>& observation : observations_) observation.pose->constant |= observation.active;
}

template <class Cost>
ObservationSums ObservationGroup<Cost>::Sum(State state) const {
  ObservationSums sums;
  for (int i = 0; i < first_.back(); ++i) {
    const AdjustedObservation<Cost>& observation = observations_[i];
    const Fit& fit = state == State::kStart ? observation.at_start : observation.now;
    if (!observation.active || !fit.in_front) continue;
    sums.squares += fit.squared;
    sums.rows += observation.cost.rows();
    sums.squares_px += fit.squared_px;
    sums.observations += 1.0;
  }
  return sums;
}

template <class Cost>
std::vector<bool> ObservationGroup<Cost>::Inliers() const {
  std::vector<bool> inliers(given_observations_, false);
  for (int i = 0; i < first_.back(); ++i) inliers[observations_[i].observation] = observations_[i].active;
  return inliers;
}

template <class Cost>
bool ObservationGroup<Cost>::IsFinite() const {
  return std::all_of(landmarks_.begin(), landmarks_.end(),
                     [](const Landmark& l) { return !l.IsUsable() || l.x.allFinite(); });
}

}  // namespace plslam
