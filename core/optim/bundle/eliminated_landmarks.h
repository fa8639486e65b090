#pragma once

#include <vector>

#include <Eigen/Cholesky>

#include "core/optim/bundle/pose_system.h"
#include "core/optim/bundle/sight_group.h"

namespace plslam {

/// Levenberg and Marquardt's damping: each diagonal element of the information grows by this share of itself.
struct Damping {
  double share = 0.0;

  /// Of the diagonal of an information.
  template <class Diagonal>
  Eigen::Matrix<double, Diagonal::RowsAtCompileTime, 1> Of(const Diagonal& diagonal) const {
    // Bounds as those of Ceres.
    return share * diagonal.array().max(1e-6).min(1e32);
  }
};

/// The landmarks of one kind in a step of all poses and landmarks. Each ties together only the poses that see it, and no
/// other landmark, so it is solved for in terms of those poses (Schur complement): what is left is a system of the poses
/// alone. Losses are twice the costs.
class EliminatedLandmarks {
 public:
  virtual ~EliminatedLandmarks() = default;

  /// Information and gradient at the state as it is, which is evaluated; those of poses are added to `poses`. Returns the
  /// loss.
  virtual double Linearise(PoseSystem& poses) = 0;

  /// Takes from `poses` what the landmarks, damped, are free to take up. False where one cannot be solved for.
  virtual bool Eliminate(const Damping& damping, PoseSystem& poses) = 0;

  /// Moves the landmarks, given the step of the poses. Returns by how much the loss falls as far as it is quadratic.
  virtual double Step(const Eigen::VectorXd& of_poses) = 0;

  /// Undoes the last step.
  virtual void TakeBack() = 0;

  /// Evaluates the state as it is.
  virtual double Loss() const = 0;

  /// The largest element of the gradients.
  virtual double Steepest() const = 0;
};

template <class Cost>
class LandmarkElimination final : public EliminatedLandmarks {
 public:
  explicit LandmarkElimination(SightGroup<Cost>& group);

  double Linearise(PoseSystem& poses) override;
  bool Eliminate(const Damping& damping, PoseSystem& poses) override;
  double Step(const Eigen::VectorXd& of_poses) override;
  void TakeBack() override;
  double Loss() const override;
  double Steepest() const override;

 private:
  static constexpr int kSize = SightGroup<Cost>::kSize;
  static constexpr int kRows = Cost::kMaxRows;
  using Parameters = typename Cost::Landmark::Parameters;
  using Information = typename SightGroup<Cost>::Information;

  /// How a landmark hangs together with a pose that sees it.
  struct Coupling {
    int pose;
    Eigen::Matrix<double, 6, kSize> H;
    /// H times the inverse root of the landmark's damped information.
    Eigen::Matrix<double, 6, kSize> half;
  };

  struct Block {
    typename Cost::Landmark* landmark;
    Information H;
    Parameters g;
    Parameters damping;
    Parameters before;
    /// Of the damped information L L^T: L^-1, and L^-1 g.
    Information inverse_root;
    Parameters half_g;
    /// Its couplings, up to those of the next landmark.
    size_t first;
  };

  void LineariseSights(const AdjustedSight<Cost>* begin, const AdjustedSight<Cost>* end, Block& block,
                       PoseSystem& poses);
  size_t EndOf(size_t block) const {
    return block + 1 < blocks_.size() ? blocks_[block + 1].first : couplings_.size();
  }

  SightGroup<Cost>& group_;
  std::vector<Block> blocks_;
  std::vector<Coupling> couplings_;
};

}  // namespace plslam

#include "core/optim/bundle/eliminated_landmarks_impl.h"
