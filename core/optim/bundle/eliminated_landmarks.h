// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/optim/bundle/observation_group.h"
#include "core/optim/bundle/pose_system.h"
#include "core/optim/solver/trust_region.h"

namespace plslam {

/// The landmarks of one feature type in a step of all poses and landmarks. A landmark is coupled only with the poses
/// that observe it, not with other landmarks, so it is eliminated: with blocks H_pp, H_pi, H_ii and gradients g, the
/// poses solve (H_pp - sum_i H_pi H_ii^-1 H_ip) x_p = -(g_p - sum_i H_pi H_ii^-1 g_i), and then each landmark solves
/// H_ii x_i = -(g_i + H_ip x_p). Losses are twice the costs.
class EliminatedLandmarks {
 public:
  virtual ~EliminatedLandmarks() = default;

  /// Computes information and gradient at the current state; adds those of poses to `poses`. Returns the loss.
  virtual double Linearise(PoseSystem& poses) = 0;

  /// Subtracts the Schur complement of the damped landmarks from `poses`. Returns false if a block is singular.
  virtual bool Eliminate(const Damping& damping, PoseSystem& poses) = 0;

  /// Moves the landmarks, given the step of the poses. Returns the landmarks' part of the predicted reduction of the
  /// loss.
  virtual double Step(const Eigen::VectorXd& of_poses) = 0;

  /// Rolls the last step back.
  virtual void RollBack() = 0;

  /// Evaluates the current state.
  virtual double Loss() const = 0;

  /// Largest absolute element of the gradients.
  virtual double LargestGradient() const = 0;
};

template <class Cost>
class LandmarkElimination final : public EliminatedLandmarks {
 public:
  explicit LandmarkElimination(ObservationGroup<Cost>& group);

  double Linearise(PoseSystem& poses) override;
  bool Eliminate(const Damping& damping, PoseSystem& poses) override;
  double Step(const Eigen::VectorXd& of_poses) override;
  void RollBack() override;
  double Loss() const override;
  double LargestGradient() const override;

 private:
  static constexpr int kSize = ObservationGroup<Cost>::kSize;
  static constexpr int kRows = Cost::kMaxRows;
  using Parameters = typename Cost::Landmark::Parameters;
  using Information = typename ObservationGroup<Cost>::Information;

  using CouplingMatrix = Eigen::Matrix<double, 6, kSize>;
  /// Block H_pi of a landmark and a pose that observes it.
  struct Coupling {
    int pose;
    CouplingMatrix H;
  };

  struct Block {
    typename Cost::Landmark* landmark;
    Information H;
    Parameters g;
    Parameters damping;
    Parameters before;
    /// For the damped information L L^T: L^-1, and L^-1 g.
    Information inverse_root;
    Parameters half_g;
    /// First of its couplings; they end at those of the next landmark.
    size_t first;
  };

  void LineariseObservations(const AdjustedObservation<Cost>* begin, const AdjustedObservation<Cost>* end,
                             Block& block, PoseSystem& poses);
  /// The coupling times L^-T of the landmark's damped information. Recomputed, because storing all would take half of
  /// the adjustment's memory.
  static CouplingMatrix HalfOf(const Coupling& coupling, const Block& block) {
    CouplingMatrix half;
    half.noalias() = coupling.H * block.inverse_root.transpose();
    return half;
  }
  size_t EndOf(size_t block) const {
    return block + 1 < blocks_.size() ? blocks_[block + 1].first : couplings_.size();
  }

  ObservationGroup<Cost>& group_;
  std::vector<Block> blocks_;
  std::vector<Coupling> couplings_;
};

}  // namespace plslam

namespace plslam {

template <class Cost>
LandmarkElimination<Cost>::LandmarkElimination(ObservationGroup<Cost>& group) : group_(group) {
  blocks_.reserve(group.landmarks().size());
  couplings_.reserve(group.observation_count());
}

template <class Cost>
double LandmarkElimination<Cost>::Linearise(PoseSystem& poses) {
  blocks_.clear();
  couplings_.clear();
  group_.ForEachLandmark([&](size_t i, const AdjustedObservation<Cost>* begin, const AdjustedObservation<Cost>* end) {
    auto& landmark = group_.landmarks()[i];
    Block block;
    block.landmark = &landmark;
    block.first = couplings_.size();
    block.H = group_.PriorInformation(i);
    block.g.noalias() = block.H * (landmark.x - landmark.start);
    LineariseObservations(begin, end, block, poses);
    if (landmark.free && begin != end) blocks_.push_back(block);
  });
  return group_.Loss().loss + group_.PriorLoss();
}

template <class Cost>
void LandmarkElimination<Cost>::LineariseObservations(const AdjustedObservation<Cost>* begin,
                                                      const AdjustedObservation<Cost>* end, Block& block,
                                                      PoseSystem& poses) {
  Eigen::Matrix<double, kRows, 1> r;
  Eigen::Matrix<double, kRows, 6, Eigen::RowMajor> by_pose;
  Eigen::Matrix<double, kRows, kSize, Eigen::RowMajor> by_landmark;
  const bool free_landmark = block.landmark->free;
  for (const AdjustedObservation<Cost>* observation = begin; observation != end; ++observation) {
    const int pose = observation->pose->column;
    if (!observation->active || (pose < 0 && !free_landmark)) continue;
    if (!observation->Evaluate(r.data(), pose < 0 ? nullptr : by_pose.data(), by_landmark.data())) continue;
    const int rows = observation->cost.rows();
    const double root = std::sqrt(PseudoHuberWeight(observation->now.squared, group_.huber_delta()));
    r.head(rows) *= root;
    by_landmark.topRows(rows) *= root;
    for (int row = rows; row < kRows; ++row) {
      r(row) = 0.0;
      by_landmark.row(row).setZero();
    }
    const Information H = by_landmark.transpose() * by_landmark;
    block.H += H;
    block.g.noalias() += by_landmark.transpose() * r;
    if (pose < 0) continue;
    by_pose.topRows(rows) *= root;
    for (int row = rows; row < kRows; ++row) by_pose.row(row).setZero();
    poses.Gradient(pose).noalias() += by_pose.transpose() * r;
    CouplingMatrix coupling;
    if constexpr (Cost::kShiftsAgainstCamera) {
      const Eigen::Matrix<double, kRows, 3> by_turn = by_pose.template rightCols<3>();
      coupling.template topRows<3>() = -H;
      coupling.template bottomRows<3>().noalias() = by_turn.transpose() * by_landmark;
      auto diagonal = poses.Diagonal(pose);
      diagonal.template topLeftCorner<3, 3>() += H;
      diagonal.template bottomLeftCorner<3, 3>() -= coupling.template bottomRows<3>();
      diagonal.template bottomRightCorner<3, 3>().noalias() += by_turn.transpose() * by_turn;
    } else {
      coupling.noalias() = by_pose.transpose() * by_landmark;
      poses.Diagonal(pose).noalias() += by_pose.transpose() * by_pose;
    }
    if (!free_landmark) continue;
    couplings_.emplace_back().pose = pose;
    couplings_.back().H = coupling;
  }
}

template <class Cost>
bool LandmarkElimination<Cost>::Eliminate(const Damping& damping, PoseSystem& poses) {
  std::vector<CouplingMatrix> halves;
  for (size_t i = 0; i < blocks_.size(); ++i) {
    Block& block = blocks_[i];
    block.damping = damping.Of(block.H.diagonal());
    Information damped = block.H;
    damped.diagonal() += block.damping;
    const Eigen::LLT<Information> root(damped);
    if (root.info() != Eigen::Success) return false;
    block.inverse_root = root.matrixL().solve(Information::Identity());
    block.half_g.noalias() = block.inverse_root * block.g;
    const size_t end = EndOf(i);
    halves.resize(end - block.first);
    for (size_t k = block.first; k < end; ++k) {
      const int pose = couplings_[k].pose;
      CouplingMatrix& half = halves[k - block.first];
      half = HalfOf(couplings_[k], block);
      poses.Gradient(pose).noalias() -= half * block.half_g;
      poses.Diagonal(pose).noalias() -= half * half.transpose();
      for (size_t j = block.first; j < k; ++j) {
        const int other_pose = couplings_[j].pose;
        const CouplingMatrix& other = halves[j - block.first];
        if (other_pose < pose) {
          poses.Below(other_pose, pose).noalias() -= half * other.transpose();
        } else if (other_pose > pose) {
          poses.Below(pose, other_pose).noalias() -= other * half.transpose();
        } else {
          // The pose observes the landmark twice.
          const Matrix6d both = half * other.transpose();
          poses.Diagonal(pose) -= both + both.transpose();
        }
      }
    }
  }
  return true;
}

template <class Cost>
double LandmarkElimination<Cost>::Step(const Eigen::VectorXd& of_poses) {
  double gain = 0.0;
  for (size_t i = 0; i < blocks_.size(); ++i) {
    Block& block = blocks_[i];
    Parameters half = block.half_g;
    const size_t end = EndOf(i);
    for (size_t k = block.first; k < end; ++k) {
      half.noalias() +=
          HalfOf(couplings_[k], block).transpose() * of_poses.template segment<6>(6 * couplings_[k].pose);
    }
    const Parameters step = -(block.inverse_root.transpose() * half);
    gain += step.dot(block.damping.cwiseProduct(step) - block.g);
    block.before = block.landmark->x;
    block.landmark->x += step;
  }
  return gain;
}

template <class Cost>
void LandmarkElimination<Cost>::RollBack() {
  for (Block& block : blocks_) block.landmark->x = block.before;
}

template <class Cost>
double LandmarkElimination<Cost>::Loss() const {
  group_.ForEachLandmark([](size_t, const AdjustedObservation<Cost>* begin, const AdjustedObservation<Cost>* end) {
    for (const AdjustedObservation<Cost>* observation = begin; observation != end; ++observation) {
      if (observation->active) observation->Refit();
    }
  });
  return group_.Loss().loss + group_.PriorLoss();
}

template <class Cost>
double LandmarkElimination<Cost>::LargestGradient() const {
  double steepest = 0.0;
  for (const Block& block : blocks_) steepest = std::max(steepest, block.g.cwiseAbs().maxCoeff());
  return steepest;
}

}  // namespace plslam
