// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/motion_estimator.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "core/geometry/symmetric.h"
#include "core/motion/normal_equations.h"

namespace plslam {
namespace {

// Steps in squared standard deviations of the motion: the first estimate only has to identify outliers.
constexpr double kCoarseStep = 0.25;
constexpr double kFineStep = 1e-3;
constexpr double kConvergedStep = 1e-2;
// Gauss-Newton iterations of each step. The covariances of the residuals follow the pose, so that convergence is linear
// where few landmarks are seen: with a factor of 0.87 on a white wall, where 10 iterations are not enough.
constexpr int kMaxIterations = 20;
// Covariances of the residuals depend on the pose, so even a good step may increase the cost slightly.
constexpr double kToleratedRise = 1e-3;
constexpr double kMinDamping = 1e-9;
constexpr double kFirstDamping = 1e-3;
// Share of the correspondences that may move behind the camera during one solve.
constexpr double kMayHide = 0.05;
constexpr double kMinRelativeEigenvalue = 1e-11;

struct Solution {
  SE3 T_cur_ref;
  NormalEquations equations;
  double step = 0.0;
  int iterations = 0;
  bool finite = true;
};

class Estimator {
 public:
  Estimator(const std::vector<PointCorrespondence>& points, const std::vector<LineCorrespondence>& lines,
            const StereoCamera& camera, const std::optional<MotionPrior>& prior, const MotionOptions& options)
      : correspondences_(points, lines, options),
        camera_(camera),
        prior_(prior),
        options_(options),
        expectations_(ExpectRobust(options.huber_delta, options.gate_sigmas)) {
    if (prior_) prior_information_ = InverseOfPositiveDefinite<6>(prior_->covariance);
  }

  std::optional<MotionEstimate> Estimate(const SE3& initial, size_t n_points, size_t n_lines) const;

 private:
  NormalEquations Build(const SE3& T_cur_ref, const ActiveSet& active) const;
  Solution Solve(const SE3& initial, double stop_step, ActiveSet& active) const;
  bool LetGo(const SE3& T_cur_ref, int& may_hide, ActiveSet& active) const;
  ActiveSet Classify(const SE3& T_cur_ref) const;
  std::optional<Matrix6d> Covariance(const Solution& solution, const ActiveSet& active) const;
  double MedianDepth(const SE3& T_cur_ref, const ActiveSet& active) const;
  void CheckFeatureTypes(MotionEstimate& estimate) const;
  bool Enough(const ActiveSet& active) const {
    return active.CountPoints() + 2 * active.CountLines() >= options_.min_inliers;
  }

  PreparedCorrespondences correspondences_;
  const StereoCamera& camera_;
  const std::optional<MotionPrior>& prior_;
  const MotionOptions& options_;
  RobustExpectations expectations_;
  Matrix6d prior_information_ = Matrix6d::Zero();
};

// Inverse right Jacobian of SE(3), to second order.
Matrix6d InverseRightJacobian(const Vector6d& x) {
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = Skew(x.tail<3>());
  ad.topRightCorner<3, 3>() = Skew(x.head<3>());
  ad.bottomRightCorner<3, 3>() = ad.topLeftCorner<3, 3>();
  return Matrix6d::Identity() + 0.5 * ad + ad * ad / 12.0;
}

// Squared robust scale: the median of squared norms over their expected medians. 0 without correspondences.
double SquaredScale(const std::vector<Deviation>& some, const std::vector<Deviation>& others = {}) {
  std::vector<double> ratios;
  ratios.reserve(some.size() + others.size());
  for (const Deviation& d : some) ratios.push_back(d.squared / d.median);
  for (const Deviation& d : others) ratios.push_back(d.squared / d.median);
  return Median(ratios);
}

NormalEquations Estimator::Build(const SE3& T_cur_ref, const ActiveSet& active) const {
  NormalEquations equations =
      BuildNormalEquations(correspondences_, active, T_cur_ref, camera_, expectations_, options_);
  if (prior_) {
    const Vector6d e = (prior_->T_cur_ref * T_cur_ref.Inverse()).Log();
    const Matrix6d J = InverseRightJacobian(e);
    const Vector6d weighted = prior_information_ * e;
    equations.H_prior = J.transpose() * prior_information_ * J;
    equations.g += J.transpose() * weighted;
    equations.cost += e.dot(weighted);
  }
  return equations;
}

// Deactivates correspondences behind the camera if they are few: the charge for each prevents bad steps from hiding
// contradicting ones, but would also reject a good step because of a landmark that the camera passes.
bool Estimator::LetGo(const SE3& T_cur_ref, int& may_hide, ActiveSet& active) const {
  ActiveSet visible = active;
  const std::vector<Deviation> points = PointDeviations(correspondences_, T_cur_ref, camera_, options_);
  const std::vector<Deviation> lines = LineDeviations(correspondences_, T_cur_ref, camera_, options_);
  for (size_t i = 0; i < points.size(); ++i) visible.points[i] &= std::isfinite(points[i].squared);
  for (size_t i = 0; i < lines.size(); ++i) visible.lines[i] &= std::isfinite(lines[i].squared);
  may_hide -= active.Count() - visible.Count();
  if (may_hide < 0) return false;
  active = std::move(visible);
  return true;
}

Solution Estimator::Solve(const SE3& initial, double stop_step, ActiveSet& active) const {
  Solution now{initial, Build(initial, active)};
  double damping = kMinDamping;
  int may_hide = std::max(1, static_cast<int>(kMayHide * active.Count()));
  for (int i = 0; i < kMaxIterations; ++i) {
    const Matrix6d H = now.equations.H();
    Matrix6d damped = H;
    damped.diagonal() *= 1.0 + damping;
    const Vector6d x = -SolveSymmetric<6>(damped, now.equations.g);
    now.finite = x.allFinite();
    if (!now.finite) break;
    now.step = x.dot(H * x);
    ++now.iterations;
    const SE3 trial = SE3::Exp(-x) * now.T_cur_ref;
    NormalEquations at_trial = Build(trial, active);
    if (at_trial.dimensions < now.equations.dimensions && LetGo(trial, may_hide, active)) {
      now.equations = Build(now.T_cur_ref, active);
      at_trial = Build(trial, active);
    }
    if (at_trial.cost <= now.equations.cost * (1.0 + kToleratedRise)) {
      now.T_cur_ref = trial;
      now.equations = at_trial;
      damping = std::max(kMinDamping, 0.1 * damping);
    } else {
      damping = std::max(kFirstDamping, 10.0 * damping);
    }
    if (now.step < stop_step) break;
  }
  return now;
}

ActiveSet Estimator::Classify(const SE3& T_cur_ref) const {
  const std::vector<Deviation> points = PointDeviations(correspondences_, T_cur_ref, camera_, options_);
  const std::vector<Deviation> lines = LineDeviations(correspondences_, T_cur_ref, camera_, options_);
  const double squared_scale = std::clamp(SquaredScale(points, lines), 1.0, options_.max_scale * options_.max_scale);
  ActiveSet active;
  active.points.reserve(points.size());
  active.lines.reserve(lines.size());
  for (const Deviation& d : points) active.points.push_back(d.squared <= squared_scale * d.gate ? 1 : 0);
  for (const Deviation& d : lines) active.lines.push_back(d.squared <= squared_scale * d.gate ? 1 : 0);
  return active;
}

double Estimator::MedianDepth(const SE3& T_cur_ref, const ActiveSet& active) const {
  std::vector<double> depths;
  for (size_t i = 0; i < active.points.size(); ++i) {
    if (active.points[i] != 0) depths.push_back((T_cur_ref * correspondences_.points[i].p_ref).z());
  }
  for (size_t i = 0; i < active.lines.size(); ++i) {
    const Segment3& s = correspondences_.lines[i].segment_ref;
    if (active.lines[i] != 0) depths.push_back((T_cur_ref * Eigen::Vector3d(0.5 * (s.p + s.q))).z());
  }
  return Median(depths);
}

std::optional<Matrix6d> Estimator::Covariance(const Solution& solution, const ActiveSet& active) const {
  const NormalEquations& e = solution.equations;
  if (e.dimensions == 0) return std::nullopt;
  // Corrects the information for the loss by robust weights, and for residuals larger than their sigmas.
  const double weighting = e.expected_weight * e.expected_B / (e.expected_A * e.expected_A);
  const double freedom = std::max(1.0, e.dimensions - 6.0) / e.dimensions;
  const double excess = std::max(1.0, e.weighted_squares / (e.expected_weighted_squares * freedom));
  const Matrix6d H = e.H_data / (weighting * excess) + e.H_prior;

  // Scales to unit diagonal first, because metres and radians differ in size.
  const Vector6d scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix6d scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const auto [values, vectors] = EigenOf<6>(scaled);
  if (!values.allFinite() || !(values.minCoeff() > kMinRelativeEigenvalue * values.maxCoeff())) return std::nullopt;
  const Matrix6d half = scale.asDiagonal() * vectors;
  const Matrix6d covariance = half * values.cwiseInverse().asDiagonal() * half.transpose();
  if (!covariance.allFinite()) return std::nullopt;
  if (!prior_) {
    const double translation = std::sqrt(covariance.diagonal().head<3>().sum());
    const double rotation = std::sqrt(covariance.diagonal().tail<3>().sum());
    const double depth = MedianDepth(solution.T_cur_ref, active);
    if (translation > options_.max_relative_sigma * depth || rotation > options_.max_relative_sigma) {
      return std::nullopt;
    }
  }
  return Matrix6d(0.5 * (covariance + covariance.transpose()));
}

void Estimator::CheckFeatureTypes(MotionEstimate& estimate) const {
  // The sigmas without their floor, which is only for gates.
  MotionOptions options = options_;
  options.min_scale_px = 0.0;
  const SE3& T = estimate.T_cur_ref;
  estimate.point_deviation = std::sqrt(SquaredScale(PointDeviations(correspondences_, T, camera_, options)));
  estimate.line_deviation = std::sqrt(SquaredScale(LineDeviations(correspondences_, T, camera_, options)));
}

std::optional<MotionEstimate> Estimator::Estimate(const SE3& initial, size_t n_points, size_t n_lines) const {
  ActiveSet active{std::vector<char>(correspondences_.points.size(), 1),
                   std::vector<char>(correspondences_.lines.size(), 1)};
  if (!Enough(active)) return std::nullopt;
  Solution solution = Solve(initial, kCoarseStep, active);
  int iterations = solution.iterations;
  for (int round = 0; round < options_.max_refinements && solution.finite; ++round) {
    ActiveSet refreshed = Classify(solution.T_cur_ref);
    if (round > 0 && refreshed == active) break;
    active = std::move(refreshed);
    if (!Enough(active)) return std::nullopt;
    solution = Solve(solution.T_cur_ref, kFineStep, active);
    iterations += solution.iterations;
  }
  if (!solution.finite || !(solution.step < kConvergedStep)) return std::nullopt;
  const std::optional<Matrix6d> covariance = Covariance(solution, active);
  if (!covariance || !solution.T_cur_ref.IsFinite()) return std::nullopt;

  MotionEstimate estimate;
  estimate.T_cur_ref = solution.T_cur_ref;
  estimate.covariance = *covariance;
  estimate.point_inliers.assign(n_points, false);
  estimate.line_inliers.assign(n_lines, false);
  for (size_t i = 0; i < active.points.size(); ++i) {
    estimate.point_inliers[correspondences_.point_index[i]] = active.points[i] != 0;
  }
  for (size_t i = 0; i < active.lines.size(); ++i) {
    estimate.line_inliers[correspondences_.line_index[i]] = active.lines[i] != 0;
  }
  estimate.n_point_inliers = active.CountPoints();
  estimate.n_line_inliers = active.CountLines();
  estimate.iterations = iterations;
  estimate.rms = std::sqrt(solution.equations.squares / solution.equations.dimensions);
  CheckFeatureTypes(estimate);
  return estimate;
}

bool IsUsable(const MotionPrior& prior) {
  return prior.T_cur_ref.IsFinite() && prior.covariance.allFinite() && IsPositiveDefinite<6>(prior.covariance);
}

}  // namespace

std::optional<MotionEstimate> EstimateMotion(const std::vector<PointCorrespondence>& points,
                                             const std::vector<LineCorrespondence>& lines, const StereoCamera& camera,
                                             const SE3& initial, const std::optional<MotionPrior>& prior,
                                             const MotionOptions& options) {
  if (!initial.IsFinite() || (prior && !IsUsable(*prior))) return std::nullopt;
  return Estimator(points, lines, camera, prior, options).Estimate(initial, points.size(), lines.size());
}

}  // namespace plslam
