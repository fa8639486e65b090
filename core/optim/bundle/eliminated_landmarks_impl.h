#pragma once

#include <algorithm>
#include <cmath>

#include "core/optim/bundle/eliminated_landmarks.h"

namespace plslam {

template <class Cost>
LandmarkElimination<Cost>::LandmarkElimination(SightGroup<Cost>& group) : group_(group) {
  blocks_.reserve(group.landmarks().size());
  couplings_.reserve(group.sight_count());
}

template <class Cost>
double LandmarkElimination<Cost>::Linearise(PoseSystem& poses) {
  blocks_.clear();
  couplings_.clear();
  group_.ForEachLandmark([&](size_t i, const AdjustedSight<Cost>* begin, const AdjustedSight<Cost>* end) {
    auto& landmark = group_.landmarks()[i];
    Block block;
    block.landmark = &landmark;
    block.first = couplings_.size();
    block.H = group_.PriorInformation(i);
    block.g.noalias() = block.H * (landmark.x - landmark.start);
    LineariseSights(begin, end, block, poses);
    if (landmark.free && begin != end) blocks_.push_back(block);
  });
  return group_.Loss().loss + group_.PriorLoss();
}

template <class Cost>
void LandmarkElimination<Cost>::LineariseSights(const AdjustedSight<Cost>* begin, const AdjustedSight<Cost>* end,
                                                Block& block, PoseSystem& poses) {
  Eigen::Matrix<double, kRows, 1> r;
  Eigen::Matrix<double, kRows, 6, Eigen::RowMajor> by_pose;
  Eigen::Matrix<double, kRows, kSize, Eigen::RowMajor> by_landmark;
  const bool free_landmark = block.landmark->free;
  for (const AdjustedSight<Cost>* sight = begin; sight != end; ++sight) {
    const int pose = sight->pose->column;
    if (!sight->active || (pose < 0 && !free_landmark)) continue;
    if (!sight->Evaluate(r.data(), pose < 0 ? nullptr : by_pose.data(), by_landmark.data())) continue;
    const int rows = sight->cost.rows();
    const double root = std::sqrt(PseudoHuberWeight(sight->now.squared, group_.huber_delta()));
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
    Eigen::Matrix<double, 6, kSize> coupling;
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
    for (size_t k = block.first; k < end; ++k) {
      Coupling& coupling = couplings_[k];
      const int pose = coupling.pose;
      coupling.half.noalias() = coupling.H * block.inverse_root.transpose();
      poses.Gradient(pose).noalias() -= coupling.half * block.half_g;
      poses.Diagonal(pose).noalias() -= coupling.half * coupling.half.transpose();
      for (size_t j = block.first; j < k; ++j) {
        const Coupling& other = couplings_[j];
        if (other.pose < pose) {
          poses.Below(other.pose, pose).noalias() -= coupling.half * other.half.transpose();
        } else if (other.pose > pose) {
          poses.Below(pose, other.pose).noalias() -= other.half * coupling.half.transpose();
        } else {
          // A pose that sees the landmark twice.
          const Matrix6d both = coupling.half * other.half.transpose();
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
      half.noalias() += couplings_[k].half.transpose() * of_poses.template segment<6>(6 * couplings_[k].pose);
    }
    const Parameters step = -(block.inverse_root.transpose() * half);
    gain += step.dot(block.damping.cwiseProduct(step) - block.g);
    block.before = block.landmark->x;
    block.landmark->x += step;
  }
  return gain;
}

template <class Cost>
void LandmarkElimination<Cost>::TakeBack() {
  for (Block& block : blocks_) block.landmark->x = block.before;
}

template <class Cost>
double LandmarkElimination<Cost>::Loss() const {
  group_.ForEachLandmark([](size_t, const AdjustedSight<Cost>* begin, const AdjustedSight<Cost>* end) {
    for (const AdjustedSight<Cost>* sight = begin; sight != end; ++sight) {
      if (sight->active) sight->Refit();
    }
  });
  return group_.Loss().loss + group_.PriorLoss();
}

template <class Cost>
double LandmarkElimination<Cost>::Steepest() const {
  double steepest = 0.0;
  for (const Block& block : blocks_) steepest = std::max(steepest, block.g.cwiseAbs().maxCoeff());
  return steepest;
}

}  // namespace plslam
