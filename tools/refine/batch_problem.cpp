// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/batch_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <set>
#include <utility>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "core/optim/bundle/line_cost.h"
#include "core/optim/bundle/relative_poses.h"
#include "core/optim/reference/line_functor.h"
#include "core/optim/reference/motion_functor.h"
#include "core/optim/reference/point_functor.h"
#include "tools/refine/batch_state.h"

namespace plslam::refine {
namespace {

using reference::kPairSize;

// As in the adjustments at run time (core/optim/bundle/options.h).
constexpr double kHuber = 1.5;
// Residual, in standard deviations, of a landmark behind a camera: constant, so that one bad landmark does not forbid a
// step of all.
constexpr double kBehind = 30.0;
// A landmark is determined if its position is known to this share of its distance; others get a weak prior.
constexpr double kDetermined = 0.3;
// Observations up to which a sparse QR factorisation takes less than about a minute.
constexpr size_t kMaxQrObservations = 120'000;

/// Replaces the failure of a landmark behind a camera by a constant.
template <class Functor>
struct Bounded {
  Functor functor;

  template <typename T, typename... Rest>
  bool operator()(const T* first, Rest... rest) const {
    T* const residuals = std::get<sizeof...(Rest) - 1>(std::tuple<Rest...>(rest...));
    if (!Call(first, rest...)) std::fill(residuals, residuals + functor.rows(), T(kBehind));
    return true;
  }

 private:
  template <typename... Arguments>
  bool Call(Arguments... arguments) const {
    return functor(arguments...);
  }
};

template <class Functor, int... kSizes>
ceres::CostFunction* MakeCost(Functor functor) {
  const int rows = functor.rows();
  using Auto = ceres::AutoDiffCostFunction<Bounded<Functor>, ceres::DYNAMIC, kSizes...>;
  return new Auto(new Bounded<Functor>{std::move(functor)}, rows);  // NOLINT: Ceres owns both.
}

bool IsUsable(const RelativePose& motion) { return Eigen::LLT<Matrix6d>(motion.covariance).info() == Eigen::Success; }

/// For each pose the first one of its part: of those that active observations and motions connect with it.
std::vector<size_t> FirstOfPart(const BatchProblem& problem) {
  const BundleProblem& bundle = problem.bundle;
  const size_t n_poses = bundle.poses.size();
  const size_t n_points = bundle.points.size();
  std::vector<int> parent(n_poses + n_points + bundle.lines.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&parent](size_t i) {
    auto k = static_cast<int>(i);
    while (parent[static_cast<size_t>(k)] != k) {
      k = parent[static_cast<size_t>(k)] = parent[static_cast<size_t>(parent[static_cast<size_t>(k)])];
    }
    return k;
  };
  const auto join = [&](int a, size_t b) {
    const int root_a = find(static_cast<size_t>(a));
    const int root_b = find(b);
    parent[static_cast<size_t>(std::max(root_a, root_b))] = std::min(root_a, root_b);
  };
  for (size_t i = 0; i < bundle.point_observations.size(); ++i) {
    const PointObservation& seen = bundle.point_observations[i];
    if (problem.point_active[i] != 0) join(seen.pose, n_poses + static_cast<size_t>(seen.point));
  }
  for (size_t i = 0; i < bundle.line_observations.size(); ++i) {
    const LineObservation& seen = bundle.line_observations[i];
    if (problem.line_active[i] != 0) join(seen.pose, n_poses + n_points + static_cast<size_t>(seen.line));
  }
  for (const RelativePose& motion : bundle.relative_poses) {
    if (IsUsable(motion)) join(motion.a, static_cast<size_t>(motion.b));
  }
  std::vector<size_t> first(n_poses);
  for (size_t i = 0; i < n_poses; ++i) first[i] = static_cast<size_t>(find(i));
  return first;
}

/// Number of poses of the parts whose scale nothing fixes: without a motion, or the depth of a landmark.
size_t PosesWithoutScale(const BatchProblem& problem) {
  const BundleProblem& bundle = problem.bundle;
  const std::vector<size_t> first = FirstOfPart(problem);
  const auto part_of = [&first](int pose) { return first[static_cast<size_t>(pose)]; };
  std::vector<size_t> poses(first.size(), 0);
  for (const size_t part : first) ++poses[part];
  std::vector<bool> fixed(first.size(), false);
  for (size_t i = 0; i < bundle.point_observations.size(); ++i) {
    const PointObservation& seen = bundle.point_observations[i];
    if (problem.point_active[i] != 0 && seen.uvd.z() >= 0.0) fixed[part_of(seen.pose)] = true;
  }
  for (size_t i = 0; i < bundle.line_observations.size(); ++i) {
    const LineObservation& seen = bundle.line_observations[i];
    const bool has_depth = seen.disparity_p_px >= 0.0 && seen.disparity_q_px >= 0.0;
    if (problem.line_active[i] != 0 && has_depth) fixed[part_of(seen.pose)] = true;
  }
  for (const RelativePose& motion : bundle.relative_poses) {
    if (IsUsable(motion)) fixed[part_of(motion.a)] = true;
  }
  size_t n = 0;
  for (size_t part = 0; part < poses.size(); ++part) {
    if (poses[part] > 1 && !fixed[part]) n += poses[part];
  }
  return n;
}

Eigen::MatrixXd InformationOf(const ceres::CostFunction& cost, const std::vector<double*>& blocks, size_t landmark) {
  const auto& sizes = cost.parameter_block_sizes();
  const int rows = cost.num_residuals();
  Eigen::VectorXd r(rows);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> J(rows, sizes[landmark]);
  std::vector<double*> jacobians(blocks.size(), nullptr);
  jacobians[landmark] = J.data();
  if (!cost.Evaluate(blocks.data(), r.data(), jacobians.data())) return Eigen::MatrixXd::Zero(J.cols(), J.cols());
  return J.transpose() * J;
}

/// A Ceres problem at a state, with the weak priors.
class CeresProblem {
 public:
  CeresProblem(const BatchProblem& problem, State& state, CameraChoice camera,
               const std::array<bool, kPairSize>& pair_free)
      : given_(problem), state_(state), with_pair_(camera != CameraChoice::kFixed) {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres_ = std::make_unique<ceres::Problem>(options);
    AddPoints();
    AddLines();
    AddMotions();
    AddPair(pair_free);
    const std::vector<size_t> first = FirstOfPart(problem);
    for (size_t i = 0; i < first.size(); ++i) {
      double* pose = state_.Pose(static_cast<int>(i));
      if (first[i] == i && ceres_->HasParameterBlock(pose)) ceres_->SetParameterBlockConstant(pose);
    }
  }

  ceres::Problem& ceres() { return *ceres_; }
  /// Conditional information of each landmark that is observed.
  const std::vector<Eigen::Matrix3d>& point_information() const { return point_information_; }
  const std::vector<Eigen::Matrix4d>& line_information() const { return line_information_; }

  void SetOrdering(ceres::Solver::Options& options) const {
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    std::vector<double*> blocks;
    ceres_->GetParameterBlocks(&blocks);
    std::set<const double*> landmarks;
    for (size_t i = 0; i < given_.bundle.points.size(); ++i) landmarks.insert(state_.Point(static_cast<int>(i)));
    for (size_t i = 0; i < given_.bundle.lines.size(); ++i) landmarks.insert(state_.Line(static_cast<int>(i)));
    for (double* block : blocks) ordering->AddElementToGroup(block, landmarks.contains(block) ? 0 : 1);
    options.linear_solver_ordering = ordering;
  }

 private:
  void AddPoints() {
    const BundleProblem& bundle = given_.bundle;
    point_information_.assign(bundle.points.size(), Eigen::Matrix3d::Zero());
    std::vector<double> nearest(bundle.points.size(), std::numeric_limits<double>::max());
    for (size_t i = 0; i < bundle.point_observations.size(); ++i) {
      if (given_.point_active[i] == 0) continue;
      const PointObservation& seen = bundle.point_observations[i];
      const auto k = static_cast<size_t>(seen.point);
      std::vector<double*> blocks{state_.Pose(seen.pose), state_.Point(seen.point)};
      ceres::CostFunction* cost = nullptr;
      if (with_pair_) {
        blocks.push_back(state_.Pair());
        cost = MakeCost<reference::PairPointFunctor, 6, 3, kPairSize>(state_.PairPointOf(i));
      } else {
        cost = MakeCost<reference::PointFunctor, 6, 3>(state_.PointOf(i));
      }
      ceres_->AddResidualBlock(cost, &loss_, blocks);
      point_information_[k] += InformationOf(*cost, blocks, 1);
      const double distance_m =
          (state_.T_w_c(seen.pose).translation() - Eigen::Map<Eigen::Vector3d>(state_.Point(seen.point))).norm();
      nearest[k] = std::min(nearest[k], distance_m);
    }
    for (size_t k = 0; k < nearest.size(); ++k) {
      AddPrior<3>(state_.Point(static_cast<int>(k)), nearest[k], point_information_[k]);
    }
  }

  void AddLines() {
    const BundleProblem& bundle = given_.bundle;
    line_information_.assign(bundle.lines.size(), Eigen::Matrix4d::Zero());
    std::vector<double> nearest(bundle.lines.size(), std::numeric_limits<double>::max());
    for (size_t i = 0; i < bundle.line_observations.size(); ++i) {
      if (given_.line_active[i] == 0) continue;
      const LineObservation& seen = bundle.line_observations[i];
      const auto k = static_cast<size_t>(seen.line);
      std::vector<double*> blocks{state_.Pose(seen.pose), state_.Line(seen.line)};
      ceres::CostFunction* cost = nullptr;
      if (with_pair_) {
        blocks.push_back(state_.Pair());
        cost = MakeCost<reference::LineFunctor, 6, 4, kPairSize>(state_.LineOf(i));
      } else {
        cost = MakeCost<reference::LineFunctor, 6, 4>(state_.LineOf(i));
      }
      ceres_->AddResidualBlock(cost, &loss_, blocks);
      line_information_[k] += InformationOf(*cost, blocks, 1);
      const Segment3 segment = state_.SegmentOf(seen.line);
      const double distance_m = (state_.T_w_c(seen.pose).translation() - 0.5 * (segment.p + segment.q)).norm();
      nearest[k] = std::min(nearest[k], distance_m);
    }
    for (size_t k = 0; k < nearest.size(); ++k) {
      AddPrior<4>(state_.Line(static_cast<int>(k)), nearest[k], line_information_[k]);
    }
  }

  template <int N>
  void AddPrior(double* block, double distance_m, Eigen::Matrix<double, N, N>& information) {
    using Vector = Eigen::Matrix<double, N, 1>;
    using Square = Eigen::Matrix<double, N, N>;
    if (information.isZero(0.0)) return;
    const double distance = std::max(distance_m, 1e-3);
    const double least = 1.0 / (kDetermined * kDetermined * distance * distance);
    const Eigen::SelfAdjointEigenSolver<Square> eigen(information, Eigen::EigenvaluesOnly);
    if (eigen.eigenvalues()(0) > least) return;
    const Square weight = Square::Identity() / distance;
    information += weight * weight;
    using Prior = reference::PriorFunctor<N>;
    auto* prior = new Prior{Eigen::Map<const Vector>(block), weight};  // NOLINT: Ceres owns both.
    auto* cost = new ceres::AutoDiffCostFunction<Prior, N, N>(prior);  // NOLINT
    ceres_->AddResidualBlock(cost, nullptr, block);
  }

  void AddMotions() {
    for (const RelativePose& motion : given_.bundle.relative_poses) {
      if (!IsUsable(motion)) continue;
      const auto start = [this](int i) { return given_.bundle.poses[static_cast<size_t>(i)].T_w_c; };
      using Motion = reference::MotionFunctor;
      auto* functor = new Motion(motion, start(motion.a), start(motion.b));    // NOLINT: Ceres owns both.
      auto* cost = new ceres::AutoDiffCostFunction<Motion, 6, 6, 6>(functor);  // NOLINT
      ceres_->AddResidualBlock(cost, &motion_loss_, state_.Pose(motion.a), state_.Pose(motion.b));
    }
  }

  void AddPair(const std::array<bool, kPairSize>& free) {
    if (!with_pair_ || !ceres_->HasParameterBlock(state_.Pair())) return;
    using Prior = reference::PriorFunctor<kPairSize>;
    auto* prior = new Prior{};  // NOLINT: Ceres owns it.
    prior->mean.setZero();
    prior->W.setZero();
    std::vector<int> constant;
    for (int i = 0; i < kPairSize; ++i) {
      prior->W(i, i) = 1.0 / PairParameterRows()[static_cast<size_t>(i)].prior_sigma;
      if (!free[static_cast<size_t>(i)]) constant.push_back(i);
    }
    ceres_->AddResidualBlock(new ceres::AutoDiffCostFunction<Prior, kPairSize, kPairSize>(prior),  // NOLINT
                             nullptr, state_.Pair());
    if (constant.size() == static_cast<size_t>(kPairSize)) {
      ceres_->SetParameterBlockConstant(state_.Pair());
    } else if (!constant.empty()) {
      ceres_->SetManifold(state_.Pair(), new ceres::SubsetManifold(kPairSize, constant));  // NOLINT
    }
  }

  const BatchProblem& given_;
  State& state_;
  bool with_pair_;
  ceres::SoftLOneLoss loss_{kHuber};
  ceres::SoftLOneLoss motion_loss_{RelativePoses::kDelta};
  std::unique_ptr<ceres::Problem> ceres_;
  std::vector<Eigen::Matrix3d> point_information_;
  std::vector<Eigen::Matrix4d> line_information_;
};

class Reporter : public ceres::IterationCallback {
 public:
  explicit Reporter(const BatchOptions& options) : options_(options) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (options_.progress) options_.progress(summary.iteration, summary.cost);
    const bool stop = options_.stop != nullptr && options_.stop->load();
    return stop ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const BatchOptions& options_;
};

ceres::Solver::Summary Solve(CeresProblem& problem, const BatchOptions& options, bool iterative) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = iterative ? ceres::ITERATIVE_SCHUR : ceres::SPARSE_SCHUR;
  solver.preconditioner_type = ceres::CLUSTER_JACOBI;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  solver.use_explicit_schur_complement = false;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = options.threads;
  solver.function_tolerance = 1e-6;
  solver.parameter_tolerance = 1e-10;
  solver.logging_type = ceres::SILENT;
  problem.SetOrdering(solver);
  Reporter reporter(options);
  solver.callbacks.push_back(&reporter);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem.ceres(), &summary);
  return summary;
}

}  // namespace

std::array<bool, kPairSize> FreeParameters(const BatchOptions& options) {
  std::array<bool, kPairSize> free = options.pair_free;
  const size_t n = options.camera == CameraChoice::kFixed        ? 0
                   : options.camera == CameraChoice::kIntrinsics ? reference::kTurnX
                                                                 : kPairSize;
  std::fill(free.begin() + static_cast<std::ptrdiff_t>(n), free.end(), false);
  // Short sequences do not tell distortion from turns of the right camera (docs/lab/refine.md).
  if (options.camera == CameraChoice::kAll) free[reference::kRadial] = false;
  return free;
}

const std::array<PairParameterRow, kPairSize>& PairParameterRows() {
  constexpr double kDeg = 1.0 / kRadPerDeg;
  static const std::array<PairParameterRow, kPairSize> rows{{
      {"focal length", "px", 40.0, 1.0},
      {"principal point x", "px", 20.0, 1.0},
      {"principal point y", "px", 20.0, 1.0},
      {"radial distortion", "%", 0.05, 100.0},
      {"right camera turned about x", "deg", 1.0 * kRadPerDeg, kDeg},
      {"right camera turned about y", "deg", 1.0 * kRadPerDeg, kDeg},
      {"right camera turned about z", "deg", 1.0 * kRadPerDeg, kDeg},
      {"baseline direction y", "deg", 2.0 * kRadPerDeg, kDeg},
      {"baseline direction z", "deg", 2.0 * kRadPerDeg, kDeg},
      {"right focal length over left", "%", 0.01, 100.0},
      {"right image later by", "ms", 0.02, 1e3},
  }};
  return rows;
}

BatchDemand ExpectedDemand(const BatchProblem& problem, const BatchOptions& options) {
  // Bytes and seconds of one iteration for each observation, block of the pose system and product of two blocks,
  // measured (docs/lab/refine.md).
  constexpr double kBytesPerObservation = 900.0;
  constexpr double kBytesPerPair = 3.0 * 36.0 * 8.0;
  constexpr double kSecondsPerObservation = 4e-6;
  constexpr double kSecondsPerProduct = 1.5e-7;
  constexpr double kFill = 3.0;
  constexpr double kIterations = 25.0;
  const BundleProblem& bundle = problem.bundle;
  std::vector<std::vector<int>> seen_by(bundle.points.size() + bundle.lines.size());
  for (const PointObservation& seen : bundle.point_observations) {
    seen_by[static_cast<size_t>(seen.point)].push_back(seen.pose);
  }
  for (const LineObservation& seen : bundle.line_observations) {
    seen_by[bundle.points.size() + static_cast<size_t>(seen.line)].push_back(seen.pose);
  }
  std::vector<std::vector<int>> covisible(bundle.poses.size());
  for (const std::vector<int>& poses : seen_by) {
    for (const int a : poses) {
      for (const int b : poses) {
        if (a < b) covisible[static_cast<size_t>(a)].push_back(b);
      }
    }
  }
  double pairs = static_cast<double>(bundle.poses.size());
  for (std::vector<int>& others : covisible) {
    std::sort(others.begin(), others.end());
    pairs += static_cast<double>(std::unique(others.begin(), others.end()) - others.begin());
  }
  const auto n = static_cast<double>(bundle.poses.size());
  const double factor = std::min(kFill * pairs, 0.5 * n * (n + 1.0));
  const auto observations = static_cast<double>(bundle.point_observations.size() + bundle.line_observations.size());
  BatchDemand demand;
  demand.iterative = factor * kBytesPerPair > static_cast<double>(options.memory_bytes);
  const double direct = demand.iterative ? 0.0 : factor;
  const double more = options.camera == CameraChoice::kFixed ? 1.0 : 2.5;
  demand.memory_mb = 1e-6 * (more * observations * kBytesPerObservation + direct * kBytesPerPair);
  const double products = demand.iterative ? 20.0 * pairs : direct * direct / std::max(1.0, n);
  demand.seconds = kIterations * (more * observations * kSecondsPerObservation + products * kSecondsPerProduct);
  return demand;
}

BatchFit FitOf(const BatchProblem& problem) { return State(problem).Fit(); }

BatchResult SolveBatch(const BatchProblem& problem, const BatchOptions& options) {
  BatchResult result;
  if (problem.bundle.poses.size() < 2) {
    result.reason = "it has fewer than two keyframes";
    return result;
  }
  if (const size_t n = PosesWithoutScale(problem); n > 0) {
    result.reason = "neither a depth nor a measured motion fixes the scale of " + std::to_string(n) + " keyframes";
    return result;
  }
  State state(problem);
  CeresProblem ceres(problem, state, options.camera, FreeParameters(options));
  if (ceres.ceres().NumResidualBlocks() == 0) {
    result.reason = "it has no observations of landmarks";
    return result;
  }
  const ceres::Solver::Summary summary = Solve(ceres, options, ExpectedDemand(problem, options).iterative);
  if (!summary.IsSolutionUsable()) {
    result.reason = "the solver failed: " + summary.message;
    return result;
  }
  result.cost_before = summary.initial_cost;
  result.cost_after = summary.final_cost;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.seconds = summary.total_time_in_seconds;
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.stopped = options.stop != nullptr && options.stop->load();
  state.Fill(result);
  result.after = state.Fit();
  result.ok = true;
  return result;
}

PairParameters PairSigmas(const BatchProblem& problem, const BatchOptions& options) {
  const std::array<bool, kPairSize> free = FreeParameters(options);
  State state(problem);
  CeresProblem ceres(problem, state, options.camera, free);
  ceres::Covariance::Options covariance_options;
  covariance_options.algorithm_type = ceres::SPARSE_QR;
  covariance_options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  covariance_options.num_threads = options.threads;
  ceres::Covariance covariance(covariance_options);
  Eigen::Matrix<double, kPairSize, kPairSize, Eigen::RowMajor> C;
  const std::vector<std::pair<const double*, const double*>> wanted{{state.Pair(), state.Pair()}};
  const bool known = covariance.Compute(wanted, &ceres.ceres()) &&
                     covariance.GetCovarianceBlock(state.Pair(), state.Pair(), C.data());
  PairParameters sigma{};
  for (int i = 0; i < kPairSize; ++i) {
    const auto k = static_cast<size_t>(i);
    if (free[k]) sigma[k] = known ? std::sqrt(std::max(0.0, C(i, i))) : std::numeric_limits<double>::infinity();
  }
  return sigma;
}

std::vector<Matrix6d> PoseCovariances(const BatchProblem& problem, const BatchOptions& options) {
  const size_t observations = problem.bundle.point_observations.size() + problem.bundle.line_observations.size();
  if (observations > kMaxQrObservations) return {};
  State state(problem);
  CeresProblem ceres(problem, state, CameraChoice::kFixed, {});
  std::vector<std::pair<const double*, const double*>> wanted;
  for (size_t i = 0; i < problem.bundle.poses.size(); ++i) {
    const double* pose = state.Pose(static_cast<int>(i));
    if (ceres.ceres().HasParameterBlock(pose)) wanted.emplace_back(pose, pose);
  }
  ceres::Covariance::Options covariance_options;
  covariance_options.algorithm_type = ceres::SPARSE_QR;
  covariance_options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  covariance_options.num_threads = options.threads;
  ceres::Covariance covariance(covariance_options);
  if (!covariance.Compute(wanted, &ceres.ceres())) return {};
  std::vector<Matrix6d> covariances(problem.bundle.poses.size(), Matrix6d::Zero());
  for (size_t i = 0; i < covariances.size(); ++i) {
    const double* pose = state.Pose(static_cast<int>(i));
    if (!ceres.ceres().HasParameterBlock(pose) || ceres.ceres().IsParameterBlockConstant(const_cast<double*>(pose)))
      continue;
    Eigen::Matrix<double, 6, 6, Eigen::RowMajor> C;
    if (!covariance.GetCovarianceBlock(pose, pose, C.data())) return {};
    // From the parameters [a; w] at zero to the right perturbation.
    Matrix6d by = Matrix6d::Identity();
    by.topLeftCorner<3, 3>() = problem.bundle.poses[i].T_w_c.R().transpose();
    covariances[i] = by * C * by.transpose();
  }
  return covariances;
}

LandmarkCovariances ConditionalCovariances(const BatchProblem& problem) {
  State state(problem);
  const CeresProblem ceres(problem, state, CameraChoice::kFixed, {});
  LandmarkCovariances covariances;
  for (const Eigen::Matrix3d& information : ceres.point_information()) {
    const bool seen = !information.isZero(0.0);
    covariances.points.push_back(seen ? information.inverse().eval() : Eigen::Matrix3d::Zero().eval());
  }
  for (size_t i = 0; i < ceres.line_information().size(); ++i) {
    std::array<Eigen::Matrix3d, 2> ends{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
    const Eigen::Matrix4d& information = ceres.line_information()[i];
    if (!information.isZero(0.0)) ends = AdjustedLine(problem.bundle.lines[i]).EndCovariances(information.inverse());
    covariances.line_p.push_back(ends[0]);
    covariances.line_q.push_back(ends[1]);
  }
  return covariances;
}

}  // namespace plslam::refine
