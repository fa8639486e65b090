#pragma once

#include <memory>
#include <vector>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>

#include "core/optim/bundle.h"
#include "core/optim/camera_view.h"
#include "core/optim/fixed_views_cost.h"
#include "core/optim/sight_cost.h"

namespace plslam {

inline int LandmarkOf(const PointSight& sight) { return sight.point; }
inline int LandmarkOf(const LineSight& sight) { return sight.line; }

/// Sums over sights that are inliers.
struct SightSums {
  double squares = 0.0;
  double rows = 0.0;
  double squares_px = 0.0;
  double sights = 0.0;
};

struct LossSum {
  double loss = 0.0;
  double rows = 0.0;
};

/// Where sights are looked at: as the adjustment was given, or as it was evaluated last.
enum class State { kStart, kNow };

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
             const SightContext& context, std::vector<AdjustedPose>& poses, const StereoCamera& camera);

  /// Numbers of all landmarks.
  size_t ParameterCount() const { return landmarks_.size() * kSize; }

  /// Residuals, weak priors, and the landmarks into group 0. Ceres works on `ParameterCount()` numbers at `parameters`; as it
  /// sorts by address, those of points and lines must be in one piece for equal input to give equal output.
  void AddTo(ceres::Problem& problem, ceres::ParameterBlockOrdering& order, ceres::LossFunction* loss,
             double* parameters);

  /// Follows Ceres' numbers.
  void Update();

  /// Twice the cost of the sights that take part, and their rows, as they were evaluated last.
  LossSum Loss() const;

  /// Takes away what stands out far from the landmark's other sights: it would pull the first step astray.
  void TrimGross();

  /// Takes away those that do not agree as they were evaluated last, where most of the landmark's sights do: others are
  /// not yet where that can be told.
  void Trim(const Gates& gates);

  /// Lets those take part that agree with the state as it is; returns how many changed.
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
  bool IsDetermined(size_t landmark, double distance_m) const;
  /// After a change: a landmark that its sights do not determine any more, and no prior holds, takes no part.
  void DropUndetermined(size_t landmark);

  double* ParametersOf(size_t landmark) const { return parameters_ + kSize * landmark; }

  const SightContext& context_;
  double* parameters_ = nullptr;
  std::vector<Landmark> landmarks_;
  /// Sights of landmark i are first_[i] to first_[i + 1].
  std::vector<int> first_;
  std::unique_ptr<SightCostFunction<Cost>[]> sights_;
  size_t given_sights_;
  /// By landmark; null where there are none.
  std::vector<std::unique_ptr<FixedViewsCost<Cost>>> fixed_views_;
  /// By landmark; null where sights suffice.
  std::vector<std::unique_ptr<WeakPrior<Landmark>>> priors_;
  bool has_free_ = false;
};

}  // namespace plslam

#include "core/optim/sight_group_impl.h"
