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

/// Sums over inliers.
struct ObservationSums {
  double squares = 0.0;
  double rows = 0.0;
  double squares_px = 0.0;
  double observations = 0.0;
};

/// State at which observations are summed: at the start, or as last evaluated.
enum class State { kStart, kNow };

/// All landmarks of one feature type with their observations, grouped by landmark. An adjustment has two groups, points
/// and lines.
template <class Cost>
class ObservationGroup {
 public:
  using Landmark = typename Cost::Landmark;
  static constexpr int kSize = Landmark::kSize;
  using Information = Eigen::Matrix<double, kSize, kSize>;

  /// Invalid observations (not finite, or of a landmark that is not) never take part; observations of a landmark behind
  /// the camera take part only after a later `Gate`.
  template <class GivenLandmark, class Observation>
  ObservationGroup(const std::vector<GivenLandmark>& landmarks, const std::vector<Observation>& observations,
                   double huber_delta, std::vector<AdjustedPose>& poses, const StereoCamera& camera);

  /// Gives weak priors to free landmarks that their observations do not determine (at infinity, observed once without
  /// disparity, along a line). The priors keep them near their start, and are negligible beside measurements.
  void HoldUndetermined();

  /// Twice the cost of the active observations, and their rows, as last evaluated.
  LossSum Loss() const;

  /// Twice the cost of the weak priors.
  double PriorLoss() const;

  /// Deactivates observations far above the landmark's other residuals: they would mislead the first step.
  void TrimGross();

  /// Deactivates outliers, as last evaluated, of landmarks most of whose observations are inliers: for other landmarks
  /// it is too early to decide.
  void Trim(const Gates& gates);

  /// Activates exactly the inliers at the current state; returns the number of changes.
  int Gate(const Gates& gates);

  /// Resets landmarks without inliers to their start.
  void RestoreLost();

  /// Marks the poses of inliers as `constant`.
  void HoldPoses();

  ObservationSums Sum(State state) const;
  /// In the order of the given observations.
  std::vector<bool> Inliers() const;
  bool IsFinite() const;
  /// Whether a free landmark is observed.
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
  /// Square root of the information of a landmark's weak prior, symmetric; zero if it has none.
  const Information& PriorWeight(size_t landmark) const { return prior_weights_[landmark]; }
  Information PriorInformation(size_t landmark) const { return prior_weights_[landmark] * prior_weights_[landmark]; }

 private:
  int Count(size_t landmark) const { return first_[landmark + 1] - first_[landmark]; }
  double DistanceTo(size_t landmark) const;
  Information InformationOf(size_t landmark) const;
  bool IsDetermined(size_t landmark, double distance_m) const;
  /// After a change: deactivates the observations of a landmark that they no longer determine, unless it has a prior.
  void DropUndetermined(size_t landmark);

  double huber_delta_;
  std::vector<Landmark> landmarks_;
  /// Observations of landmark i are those from first_[i] up to first_[i + 1].
  std::vector<int> first_;
  std::vector<AdjustedObservation<Cost>> observations_;
  size_t given_observations_;
  std::vector<Information> prior_weights_;
  bool has_free_ = false;
};

}  // namespace plslam

#include "core/optim/bundle/observation_group_impl.h"
