#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>

#include "core/motion/robust.h"
#include "core/optim/bundle.h"
#include "core/optim/camera_view.h"

namespace plslam {

/// Largest squared norm of an inlier's whitened residuals; index: rows.
using Gates = std::array<double, 5>;

inline int LandmarkOf(const PointSight& sight) { return sight.point; }
inline int LandmarkOf(const LineSight& sight) { return sight.line; }

/// Sums over sights that are inliers.
struct SightSums {
  double squares = 0.0;
  double rows = 0.0;
  double squares_px = 0.0;
  double sights = 0.0;
};

/// Where sights are looked at: as the adjustment was given, or as it is.
enum class State { kStart, kNow };

/// One sight as Ceres sees it. What it has of a pose comes from the pose's view, which the solver keeps up to date. Sights
/// that do not take part cost nothing; those that a step brings behind the camera cost a constant, so that
/// one bad landmark does not forbid the step.
template <class Cost>
class SightCostFunction final : public ceres::CostFunction {
 public:
  using Landmark = typename Cost::Landmark;

  void Bind(const Cost& cost_in, AdjustedPose& pose_in, Landmark& landmark_in, int sight_in) {
    cost = cost_in;
    pose = &pose_in;
    landmark = &landmark_in;
    sight = sight_in;
    set_num_residuals(cost.rows());
    if (landmark->free) mutable_parameter_block_sizes()->push_back(Landmark::kSize);
    if (pose->IsFree()) mutable_parameter_block_sizes()->push_back(6);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double* x = landmark->free ? parameters[0] : landmark->x.data();
    double* by_landmark = jacobians && landmark->free ? jacobians[0] : nullptr;
    double* by_pose = jacobians && pose->IsFree() ? jacobians[landmark->free ? 1 : 0] : nullptr;
    if (active && cost.Evaluate(pose->view, x, residuals, by_pose, by_landmark)) return true;
    std::fill_n(residuals, cost.rows(), 0.0);
    if (active) residuals[0] = kBehind;
    if (by_landmark) std::fill_n(by_landmark, cost.rows() * Landmark::kSize, 0.0);
    if (by_pose) std::fill_n(by_pose, cost.rows() * 6, 0.0);
    return true;
  }

  /// Whether the sight agrees with the state: squared norm below the gate, and in front.
  bool Agrees(const Gates& gates) const {
    double r[Cost::kMaxRows];
    if (!cost.Evaluate(pose->view, landmark->x.data(), r, nullptr, nullptr)) return false;
    double squared = 0.0;
    for (int i = 0; i < cost.rows(); ++i) squared += r[i] * r[i];
    return squared <= gates[cost.rows()];
  }

  Cost cost;
  AdjustedPose* pose = nullptr;
  Landmark* landmark = nullptr;
  int sight = -1;
  bool active = false;

 private:
  /// In standard deviations.
  static constexpr double kBehind = 30.0;
};

/// Holds a landmark near its start where sights alone do not: at infinity, seen once without disparity, along a line.
/// It is nothing beside what is measured.
template <class Landmark>
class WeakPrior final : public ceres::CostFunction {
 public:
  using Information = Eigen::Matrix<double, Landmark::kSize, Landmark::kSize>;

  /// The deviation is the distance to the landmark; along a line a hundredth of the length.
  WeakPrior(const Landmark& landmark, double distance_m)
      : start_(landmark.start), weight_(landmark.PriorWeight(distance_m)) {
    set_num_residuals(Landmark::kSize);
    mutable_parameter_block_sizes()->push_back(Landmark::kSize);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    using Parameters = typename Landmark::Parameters;
    Eigen::Map<Parameters>{residuals} = weight_ * (Eigen::Map<const Parameters>(parameters[0]) - start_);
    if (jacobians && jacobians[0]) {
      // Symmetric, so rows or columns first are the same.
      Eigen::Map<Information>{jacobians[0]} = weight_;
    }
    return true;
  }

  Information information() const { return weight_ * weight_; }

 private:
  typename Landmark::Parameters start_;
  Information weight_;
};

/// All landmarks of one kind and their sights, in the order of the landmarks. Points and lines are two of these.
template <class Cost>
class SightGroup {
 public:
  using Landmark = typename Cost::Landmark;
  static constexpr int kSize = Landmark::kSize;
  using Information = Eigen::Matrix<double, kSize, kSize>;

  /// Sights that cannot be measured (not finite, of landmarks that are not) take no part, now or later; those that the
  /// landmark is behind of take none until a gate lets them in.
  template <class GivenLandmark, class Sight>
  SightGroup(const std::vector<GivenLandmark>& landmarks, const std::vector<Sight>& sights,
             std::vector<AdjustedPose>& poses, const StereoCamera& camera);

  void AddTo(ceres::Problem& problem, ceres::ParameterBlockOrdering& order, ceres::LossFunction* loss);

  /// To be called before each pass: holds what the sights that now take part do not.
  void AddPriorsTo(ceres::Problem& problem);

  /// Lets those take part that agree; returns how many changed.
  int Gate(const Gates& gates);

  /// Puts back where they were the landmarks that no sight agrees with.
  void RestoreLost();

  SightSums Sum(State state) const;
  /// In the order of the sights given.
  std::vector<bool> Inliers() const;
  bool IsFinite() const;
  /// Any free landmark that is seen.
  bool HasFree() const { return has_free_; }

  /// Calls `visit(landmark index, first, last)` for each landmark with its range of `sights()`.
  template <class Visitor>
  void ForEachLandmark(Visitor visit) const {
    for (size_t i = 0; i < landmarks_.size(); ++i) visit(i, &sights_[first_[i]], &sights_[first_[i]] + Count(i));
  }

  const std::vector<Landmark>& landmarks() const { return landmarks_; }
  int sight_count() const { return first_.back(); }
  /// Of the weak prior of a landmark; zero where there is none.
  Information PriorOf(size_t landmark) const {
    return priors_[landmark] ? priors_[landmark]->information() : Information::Zero();
  }

 private:
  int Count(size_t landmark) const { return first_[landmark + 1] - first_[landmark]; }
  double DistanceTo(size_t landmark) const;
  Information InformationOf(size_t landmark) const;

  std::vector<Landmark> landmarks_;
  /// Sights of landmark i are first_[i] to first_[i + 1].
  std::vector<int> first_;
  std::unique_ptr<SightCostFunction<Cost>[]> sights_;
  size_t given_sights_;
  /// By landmark; null where sights suffice.
  std::vector<std::unique_ptr<WeakPrior<Landmark>>> priors_;
  /// By landmark: whether its sights have changed since priors were added.
  std::vector<char> changed_;
  bool has_free_ = false;
};

}  // namespace plslam

#include "core/optim/sight_group_impl.h"
