#pragma once

#include <vector>

#include <Eigen/Cholesky>

#include "core/optim/bundle/adjusted_sight.h"
#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/camera_view.h"
#include "core/optim/bundle/step_judge.h"

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
  SightGroup(const std::vector<GivenLandmark>& landmarks, const std::vector<Sight>& sights, double huber_delta,
             std::vector<AdjustedPose>& poses, const StereoCamera& camera);

  /// Numbers of all landmarks.
  size_t ParameterCount() const { return landmarks_.size() * kSize; }

  /// Gives weak priors to the free landmarks that their sights do not determine (at infinity, seen once without
  /// disparity, along a line). They hold them near their start, and are nothing beside what is measured.
  void HoldUndetermined();

  /// Twice the cost of the sights that take part, and their rows, as they were evaluated last.
  LossSum Loss() const;

  /// Twice the cost of the weak priors.
  double PriorLoss() const;

  /// Takes away what stands out far from the landmark's other sights: it would pull the first step astray.
  void TrimGross();

  /// Takes away those that do not agree as they were evaluated last, where most of the landmark's sights do: others are
  /// not yet where that can be told.
  void Trim(const Gates& gates);

  /// Lets those take part that agree with the state as it is; returns how many changed.
  int Gate(const Gates& gates);

  /// Puts back where they were the landmarks that no sight agrees with.
  void RestoreLost();

  /// Says of the poses that a sight agrees with that they are held.
  void HoldPoses();

  SightSums Sum(State state) const;
  /// In the order of the sights given.
  std::vector<bool> Inliers() const;
  bool IsFinite() const;
  /// Any free landmark that is seen.
  bool HasFree() const { return has_free_; }

  /// Calls `visit(landmark index, first, last)` for each landmark with its range of `sights()`.
  template <class Visitor>
  void ForEachLandmark(Visitor visit) const {
    for (size_t i = 0; i < landmarks_.size(); ++i)
      visit(i, sights_.data() + first_[i], sights_.data() + first_[i + 1]);
  }

  const std::vector<Landmark>& landmarks() const { return landmarks_; }
  std::vector<Landmark>& landmarks() { return landmarks_; }
  int sight_count() const { return first_.back(); }
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
  /// After a change: a landmark that its sights do not determine any more, and no prior holds, takes no part.
  void DropUndetermined(size_t landmark);

  double huber_delta_;
  std::vector<Landmark> landmarks_;
  /// Sights of landmark i are first_[i] to first_[i + 1].
  std::vector<int> first_;
  std::vector<AdjustedSight<Cost>> sights_;
  size_t given_sights_;
  std::vector<Information> prior_weights_;
  bool has_free_ = false;
};

}  // namespace plslam

#include "core/optim/bundle/sight_group_impl.h"
