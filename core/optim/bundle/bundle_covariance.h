// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Cholesky>

#include "core/optim/bundle/observation_group.h"
#include "core/optim/bundle/reduced_information.h"

namespace plslam {

/// Covariances of an adjustment's result, from the information of the final inliers: landmarks are eliminated one by
/// one (Schur complement S = H_pp - sum_i H_pi H_ii^-1 H_ip), and S is inverted.
///
/// Each observation counts with its robust weight and a factor that makes the inverse of the weighted information a
/// consistent covariance (see RobustExpectation). Residuals larger than their sigmas enlarge all covariances.
class BundleCovariance {
 public:
  BundleCovariance(int free_poses, double huber_delta, double gate_sigmas)
      : delta_(huber_delta),
        expectations_(ExpectRobust(huber_delta, gate_sigmas)),
        reduced_(free_poses),
        free_poses_(free_poses) {}

  /// Eliminates the landmarks of one feature type. Returns the covariances of their parameters given all poses, without
  /// `Excess`; zero for landmarks that are fixed, have no inliers, or have singular information.
  template <class Cost>
  std::vector<typename ObservationGroup<Cost>::Information> Eliminate(const ObservationGroup<Cost>& group);

  /// Factor of all covariances: weighted squares over their expectation, at least 1.
  double Excess() const;

  /// Covariances of the poses' right perturbations; zero for fixed poses.
  std::vector<Matrix6d> OfPoses(const std::vector<AdjustedPose>& poses) const;

 private:
  template <class Cost>
  using Coupling = Eigen::Matrix<double, 6, Cost::Landmark::kSize>;

  double delta_;
  RobustExpectations expectations_;
  ReducedInformation reduced_;
  int free_poses_;
  double weighted_squares_ = 0.0;
  double expected_squares_ = 0.0;
  double rows_ = 0.0;
  double landmark_parameters_ = 0.0;
};

template <class Cost>
std::vector<typename ObservationGroup<Cost>::Information> BundleCovariance::Eliminate(
    const ObservationGroup<Cost>& group) {
  using Information = typename ObservationGroup<Cost>::Information;
  constexpr int kSize = ObservationGroup<Cost>::kSize;
  constexpr int kRows = Cost::kMaxRows;
  std::vector<Information> covariances(group.landmarks().size(), Information::Zero());
  std::vector<std::pair<int, Coupling<Cost>>> couplings;
  Eigen::Matrix<double, kRows, 1> r;
  Eigen::Matrix<double, kRows, 6, Eigen::RowMajor> by_pose;
  Eigen::Matrix<double, kRows, kSize, Eigen::RowMajor> by_landmark;
  group.ForEachLandmark([&](size_t i, const AdjustedObservation<Cost>* begin, const AdjustedObservation<Cost>* end) {
    const auto& landmark = group.landmarks()[i];
    Information H = group.PriorInformation(i);
    couplings.clear();
    bool seen = false;
    for (const AdjustedObservation<Cost>* observation = begin; observation != end; ++observation) {
      if (!observation->active) continue;
      r.setZero();
      by_pose.setZero();
      by_landmark.setZero();
      const CameraView& view = observation->pose->view;
      if (!observation->cost.Evaluate(view, landmark.x.data(), r.data(), by_pose.data(), by_landmark.data()))
        continue;
      seen = true;
      const int rows = observation->cost.rows();
      const RobustExpectation& expected = expectations_[rows];
      const double squared = r.squaredNorm();
      const double weight = PseudoHuberWeight(squared, delta_);
      weighted_squares_ += weight * squared;
      expected_squares_ += expected.A * rows / expected.probability;
      rows_ += rows;
      const double information = weight * expected.A * expected.A / (expected.B * expected.weight);
      if (landmark.free) H.noalias() += information * by_landmark.transpose() * by_landmark;
      const int column = observation->pose->column;
      if (column < 0) continue;
      reduced_.Add(column, column, information * by_pose.transpose() * by_pose);
      if (landmark.free) couplings.emplace_back(column, information * by_pose.transpose() * by_landmark);
    }
    if (!landmark.free || !seen) return;
    landmark_parameters_ += kSize;
    const Eigen::LLT<Information> root(H);
    if (root.info() != Eigen::Success || !H.allFinite()) return;
    covariances[i] = root.solve(Information::Identity());
    for (size_t a = 0; a < couplings.size(); ++a) {
      const Coupling<Cost> half = couplings[a].second * covariances[i];
      for (size_t b = 0; b < couplings.size(); ++b) {
        if (couplings[a].first > couplings[b].first) continue;
        reduced_.Add(couplings[a].first, couplings[b].first, -half * couplings[b].second.transpose());
      }
    }
  });
  return covariances;
}

}  // namespace plslam
