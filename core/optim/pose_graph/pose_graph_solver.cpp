// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph_solver.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/optim/pose_graph/pose_graph_check.h"
#include "core/optim/pose_graph/pose_graph_group.h"
#include "core/optim/solver/block_cholesky.h"
#include "core/optim/solver/trust_region.h"

namespace plslam {
namespace {

// Convergence: steps shorter than this share of the poses' coordinates, and predicted reductions below this share of
// the chi-square.
constexpr double kShortStep = 1e-12;
constexpr double kNoGain = 1e-15;

/// One minimisation from a start. Costs are chi-squares: twice those of Ceres.
template <class Pose>
class Descent {
 public:
  Descent(const PoseGraph<Pose>& graph, const std::vector<bool>& rejected, const std::vector<Pose>& start,
          const PoseGraphOptions& options)
      : graph_(graph), rejected_(rejected), options_(options), T_w_kf_(start), column_(start.size(), -1) {
    const std::vector<bool> constant = ConstantPoses(graph, rejected);
    for (size_t i = 0; i < start.size(); ++i) {
      if (!constant[i]) column_[i] = n_columns_++;
    }
    H_ = SymmetricBlocks<kFreedom>(n_columns_);
    g_.setZero(kFreedom * n_columns_);
  }

  PoseGraphSolve<Pose> Run() {
    PoseGraphSolve<Pose> solve;
    TrustRegion region;
    chi2_ = Linearise();
    int without_step = 0;
    bool failed = false;
    bool improving = true;
    while (improving && solve.iterations < options_.max_iterations) {
      ++solve.iterations;
      const std::optional<Eigen::VectorXd> step = Step(region.damping());
      const double predicted = step ? step->dot(damping_.cwiseProduct(*step) - g_) : 0.0;
      if (!step || !(predicted > 0.0)) {
        failed = !step || !std::isfinite(predicted);
        if (++without_step == TrustRegion::kMaxWithoutStep) break;
        region.Rejected();
        continue;
      }
      failed = false;
      without_step = 0;
      if (step->norm() <= kShortStep * Length() || predicted <= kNoGain * chi2_) break;
      std::vector<Pose> moved = Moved(*step);
      const double chi2 = Chi2(moved);
      const double gain = chi2_ - chi2;
      if (gain > TrustRegion::kMinGainRatio * predicted) {
        region.Accepted(gain / predicted);
        improving = gain > options_.function_tolerance * chi2_;
        T_w_kf_ = std::move(moved);
        chi2_ = chi2;
        if (improving && solve.iterations < options_.max_iterations) Linearise();
      } else {
        region.Rejected();
        improving = gain != 0.0;
      }
    }
    solve.chi2 = chi2_;
    solve.ok = !failed && std::isfinite(chi2_) &&
               std::all_of(T_w_kf_.begin(), T_w_kf_.end(), [](const Pose& pose) { return pose.IsFinite(); });
    if (solve.ok) solve.T_w_kf = std::move(T_w_kf_);
    return solve;
  }

 private:
  static constexpr int kFreedom = kPoseFreedom<Pose>;
  using Group = PoseGroup<Pose>;

  /// Computes information and gradient at the current poses. Returns the chi-square.
  double Linearise() {
    H_.SetZero();
    g_.setZero();
    double chi2 = 0.0;
    for (size_t i = 0; i < graph_.edges.size(); ++i) {
      if (rejected_[i]) continue;
      const PoseGraphMotion<Pose>& edge = graph_.edges[i];
      const PoseEdgeError<Pose> error = Group::Error(edge.T_a_b, T_w_kf_[At(edge.a)], T_w_kf_[At(edge.b)]);
      const Eigen::Matrix<double, kFreedom, 1> weighted = edge.information * error.e;
      chi2 += error.e.dot(weighted);
      const int a = column_[At(edge.a)];
      const int b = column_[At(edge.b)];
      const PoseMatrix<Pose> by_a_weighted = error.by_a.transpose() * edge.information;
      const PoseMatrix<Pose> by_b_weighted = error.by_b.transpose() * edge.information;
      if (a >= 0) Add(a, by_a_weighted * error.by_a, error.by_a.transpose() * weighted);
      if (b >= 0) Add(b, by_b_weighted * error.by_b, error.by_b.transpose() * weighted);
      if (a < 0 || b < 0) continue;
      if (a < b) {
        H_.Below(a, b) += by_b_weighted * error.by_a;
      } else {
        H_.Below(b, a) += by_a_weighted * error.by_b;
      }
    }
    return chi2;
  }

  void Add(int column, const PoseMatrix<Pose>& information, const Eigen::Matrix<double, kFreedom, 1>& gradient) {
    H_.diagonal[At(column)] += information;
    g_.template segment<kFreedom>(kFreedom * column) += gradient;
  }

  /// Returns nullopt if the damped system cannot be solved.
  std::optional<Eigen::VectorXd> Step(const Damping& damping) {
    damped_.diagonal = H_.diagonal;
    damped_.rows = H_.rows;
    damped_.below = H_.below;
    damping_.resize(g_.size());
    for (int i = 0; i < n_columns_; ++i) {
      auto of_pose = damping_.template segment<kFreedom>(kFreedom * i);
      of_pose = damping.Of(H_.diagonal[At(i)].diagonal());
      damped_.diagonal[At(i)].diagonal() += of_pose;
    }
    if (!cholesky_.Factorise(damped_)) return std::nullopt;
    return -cholesky_.Solve(g_);
  }

  std::vector<Pose> Moved(const Eigen::VectorXd& step) const {
    std::vector<Pose> moved = T_w_kf_;
    for (size_t i = 0; i < moved.size(); ++i) {
      if (column_[i] >= 0) moved[i] = Group::Plus(moved[i], step.data() + kFreedom * column_[i]);
    }
    return moved;
  }

  double Chi2(const std::vector<Pose>& T_w_kf) const {
    double sum = 0.0;
    for (size_t i = 0; i < graph_.edges.size(); ++i) {
      if (!rejected_[i]) sum += EdgeChi2(graph_.edges[i], T_w_kf);
    }
    return sum;
  }

  double Length() const {
    double squared = 0.0;
    for (const Pose& pose : T_w_kf_) squared += pose.translation().squaredNorm() + 1.0;
    return std::sqrt(squared);
  }

  static size_t At(int i) { return static_cast<size_t>(i); }

  const PoseGraph<Pose>& graph_;
  const std::vector<bool>& rejected_;
  const PoseGraphOptions& options_;
  std::vector<Pose> T_w_kf_;
  /// Index of each pose among the free ones, or -1.
  std::vector<int> column_;
  int n_columns_ = 0;
  double chi2_ = 0.0;
  SymmetricBlocks<kFreedom> H_;
  SymmetricBlocks<kFreedom> damped_;
  Eigen::VectorXd g_;
  Eigen::VectorXd damping_;
  BlockCholesky<kFreedom> cholesky_;
};

}  // namespace

template <class Pose>
PoseGraphSolve<Pose> SolvePoseGraph(const PoseGraph<Pose>& graph, const std::vector<bool>& rejected,
                                    const std::vector<Pose>& start, const PoseGraphOptions& options) {
  return Descent<Pose>(graph, rejected, start, options).Run();
}

template PoseGraphSolve<SE3> SolvePoseGraph(const PoseGraph<SE3>&, const std::vector<bool>&, const std::vector<SE3>&,
                                            const PoseGraphOptions&);
template PoseGraphSolve<SE2> SolvePoseGraph(const PoseGraph<SE2>&, const std::vector<bool>&, const std::vector<SE2>&,
                                            const PoseGraphOptions&);

}  // namespace plslam
