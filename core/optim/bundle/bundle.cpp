// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/bundle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/optim/bundle/bundle_covariance.h"
#include "core/optim/bundle/line_cost.h"
#include "core/optim/bundle/line_endpoint_cost.h"
#include "core/optim/bundle/observation_group.h"
#include "core/optim/bundle/point_cost.h"
#include "core/optim/bundle/relative_poses.h"
#include "core/optim/bundle/schur_solver.h"

namespace plslam {
namespace {

// Share of observations below which changes of inliers do not justify another pass.
constexpr double kFewChanges = 0.005;

template <class Observation>
std::string IndexFault(const char* kind, const std::vector<Observation>& observations, size_t poses,
                       size_t landmarks) {
  const auto is_place = [](int i, size_t size) { return i >= 0 && static_cast<size_t>(i) < size; };
  for (size_t i = 0; i < observations.size(); ++i) {
    if (is_place(observations[i].pose, poses) && is_place(LandmarkOf(observations[i]), landmarks)) continue;
    return std::string(kind) + " observation " + std::to_string(i) + " is of pose " +
           std::to_string(observations[i].pose) + " of " + std::to_string(poses) + " and " + kind + " " +
           std::to_string(LandmarkOf(observations[i])) + " of " + std::to_string(landmarks);
  }
  return {};
}

template <class Motion>
std::string IndexFault(const char* kind, const std::vector<Motion>& motions, size_t poses) {
  const auto is_pose = [poses](int i) { return i >= 0 && static_cast<size_t>(i) < poses; };
  for (const Motion& motion : motions) {
    if (is_pose(motion.a) && is_pose(motion.b)) continue;
    return std::string(kind) + " is between poses " + std::to_string(motion.a) + " and " + std::to_string(motion.b) +
           " of " + std::to_string(poses);
  }
  return {};
}

// Returns why the problem is invalid as a whole; empty if it is valid.
std::string Fault(const BundleProblem& problem) {
  const StereoCamera& camera = problem.camera;
  const bool finite = std::isfinite(camera.f_px + camera.cx_px + camera.cy_px + camera.baseline_m);
  if (!finite || !(camera.f_px > 0.0) || !(camera.baseline_m > 0.0)) {
    return "camera has focal length " + std::to_string(camera.f_px) + " px and baseline " +
           std::to_string(camera.baseline_m) + " m";
  }
  for (size_t i = 0; i < problem.poses.size(); ++i) {
    if (!problem.poses[i].T_w_c.IsFinite()) return "pose " + std::to_string(i) + " is not finite";
  }
  std::string fault = IndexFault("a relative pose", problem.relative_poses, problem.poses.size());
  if (fault.empty()) fault = IndexFault("an inertial motion", problem.inertial_motions, problem.poses.size());
  if (fault.empty())
    fault = IndexFault("point", problem.point_observations, problem.poses.size(), problem.points.size());
  if (!fault.empty()) return fault;
  return IndexFault("line", problem.line_observations, problem.poses.size(), problem.lines.size());
}

// If nothing is fixed, the first pose is constant, to fix the gauge.
std::vector<AdjustedPose> MakePoses(const BundleProblem& problem) {
  const auto is_fixed = [](const auto& item) { return item.fixed; };
  bool hold_next = std::none_of(problem.poses.begin(), problem.poses.end(), is_fixed) &&
                   std::none_of(problem.points.begin(), problem.points.end(), is_fixed) &&
                   std::none_of(problem.lines.begin(), problem.lines.end(), is_fixed);
  std::vector<AdjustedPose> poses;
  poses.reserve(problem.poses.size());
  int columns = 0;
  for (const BundlePose& pose : problem.poses) {
    poses.emplace_back(pose.T_w_c, pose.fixed || std::exchange(hold_next, false) ? -1 : columns++);
  }
  return poses;
}

Gates MakeGates(double gate_sigmas) {
  Gates gates{};
  for (int rows = 1; rows < static_cast<int>(gates.size()); ++rows)
    gates[rows] = ChiSquareQuantile(rows, gate_sigmas);
  return gates;
}

BundleResult AsGiven(const BundleProblem& problem) {
  BundleResult result;
  for (const BundlePose& pose : problem.poses) result.T_w_c.push_back(pose.T_w_c);
  for (const BundlePoint& point : problem.points) result.points.push_back(point.p_w);
  for (const BundleLine& line : problem.lines) result.lines.push_back(line.segment_w);
  result.point_inliers.assign(problem.point_observations.size(), false);
  result.line_inliers.assign(problem.line_observations.size(), false);
  return result;
}

// Points and lines of one adjustment; `Line` is the parameterisation and cost of lines.
template <class Line>
class Adjustment {
 public:
  Adjustment(const BundleProblem& problem, const BundleOptions& options)
      : given_(problem),
        options_(options),
        gates_(MakeGates(options.gate_sigmas)),
        poses_(MakePoses(problem)),
        points_(problem.points, problem.point_observations, options.huber_delta, poses_, problem.camera),
        lines_(problem.lines, problem.line_observations, options.huber_delta, poses_, problem.camera),
        relative_poses_(problem.relative_poses, poses_),
        inertial_(problem, poses_) {}

  BundleResult Run(const std::atomic<bool>* stop, BundleCovariances covariances) {
    BundleResult result = AsGiven(given_);
    const bool free_pose =
        std::any_of(poses_.begin(), poses_.end(), [](const auto& pose) { return pose.IsAdjusted(); });
    if (!free_pose && !points_.HasFree() && !lines_.HasFree()) {
      result.reason = "no free pose or landmark is observed";
      return result;
    }
    if (!Solve(stop, result)) return result;
    Fill(result);
    if (covariances == BundleCovariances::kAll) FillCovariances(result);
    return result;
  }

 private:
  bool Solve(const std::atomic<bool>* stop, BundleResult& result) {
    // Only with a later pass, which can activate these observations again.
    if (options_.max_refinements > 0) {
      points_.TrimGross();
      lines_.TrimGross();
    }
    points_.HoldUndetermined();
    lines_.HoldUndetermined();
    StepControl control(Actions(), options_, stop);
    const bool solved = RunPasses(control, result);
    RestoreLost();
    if (!solved) result.reason = "the solver failed";
    return solved;
  }

  // Landmarks and poses without inliers return to their start, instead of where outliers moved them.
  void RestoreLost() {
    points_.RestoreLost();
    lines_.RestoreLost();
    points_.HoldPoses();
    lines_.HoldPoses();
    relative_poses_.HoldPoses();
    inertial_.HoldPoses();
    for (AdjustedPose& pose : poses_) {
      if (!pose.constant) pose.Restore();
    }
  }

  ObservationActions Actions() {
    ObservationActions actions;
    actions.loss = [this] {
      const LossSum points = points_.Loss();
      const LossSum lines = lines_.Loss();
      return LossSum{points.loss + lines.loss, points.rows + lines.rows};
    };
    actions.other_loss = [this] {
      return points_.PriorLoss() + lines_.PriorLoss() + relative_poses_.Loss() + inertial_.Loss();
    };
    actions.trim = [this] {
      points_.Trim(gates_);
      lines_.Trim(gates_);
    };
    return actions;
  }

  bool RunPasses(StepControl& control, BundleResult& result) {
    LandmarkElimination<PointCost> points(points_);
    LandmarkElimination<Line> lines(lines_);
    SchurSolver solver(poses_, relative_poses_, inertial_, {&points, &lines}, options_);
    for (int refinement = 0; refinement <= options_.max_refinements && !result.stopped; ++refinement) {
      const BundlePass pass = solver.Run(control, refinement == 0 && options_.max_refinements > 0);
      result.stopped = pass.stopped;
      result.converged |= !pass.stopped;
      result.iterations += pass.iterations;
      if (!pass.ok || !IsFinite()) return false;
      const int changed = points_.Gate(gates_) + lines_.Gate(gates_);
      if (changed <= kFewChanges * (points_.observation_count() + lines_.observation_count())) break;
    }
    return true;
  }

  bool IsFinite() const {
    const auto finite = [](const AdjustedPose& pose) { return pose.x.allFinite(); };
    return std::all_of(poses_.begin(), poses_.end(), finite) && points_.IsFinite() && lines_.IsFinite();
  }

  void Fill(BundleResult& result) const {
    result.ok = true;
    for (size_t i = 0; i < poses_.size(); ++i) result.T_w_c[i] = poses_[i].T_w_c();
    for (size_t i = 0; i < result.points.size(); ++i) result.points[i] = points_.landmarks()[i].x;
    for (size_t i = 0; i < result.lines.size(); ++i) result.lines[i] = lines_.landmarks()[i].Segment();
    result.point_inliers = points_.Inliers();
    result.line_inliers = lines_.Inliers();
    result.before = Rms(State::kStart);
    result.after = Rms(State::kNow);
  }

  void FillCovariances(BundleResult& result) const {
    BundleCovariance covariance(CountFree(poses_), options_.huber_delta, options_.gate_sigmas);
    const auto of_points = covariance.Eliminate(points_);
    const auto of_lines = covariance.Eliminate(lines_);
    const double excess = covariance.Excess();
    result.pose_covariances = covariance.OfPoses(poses_);
    for (const Eigen::Matrix3d& of_point : of_points) result.point_covariances.push_back(excess * of_point);
    for (size_t i = 0; i < of_lines.size(); ++i) {
      // Lines without inliers may have no direction.
      std::array<Eigen::Matrix3d, 2> ends{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
      if (!of_lines[i].isZero(0.0)) ends = lines_.landmarks()[i].EndCovariances(excess * of_lines[i]);
      result.line_p_covariances.push_back(ends[0]);
      result.line_q_covariances.push_back(ends[1]);
    }
  }

  BundleRms Rms(State state) const {
    const ObservationSums points = points_.Sum(state);
    const ObservationSums lines = lines_.Sum(state);
    BundleRms rms;
    rms.normalised = std::sqrt((points.squares + lines.squares) / std::max(1.0, points.rows + lines.rows));
    rms.point_px = std::sqrt(points.squares_px / std::max(1.0, points.observations));
    rms.line_px = std::sqrt(lines.squares_px / std::max(1.0, lines.observations));
    return rms;
  }

  const BundleProblem& given_;
  const BundleOptions& options_;
  Gates gates_;
  std::vector<AdjustedPose> poses_;
  ObservationGroup<PointCost> points_;
  ObservationGroup<Line> lines_;
  RelativePoses relative_poses_;
  InertialChain inertial_;
};

}  // namespace

BundleResult AdjustBundle(const BundleProblem& problem, const BundleOptions& options, const std::atomic<bool>* stop,
                          BundleCovariances covariances) {
  const std::string fault = Fault(problem);
  if (!fault.empty()) {
    BundleResult result = AsGiven(problem);
    result.reason = fault;
    return result;
  }
  if (options.lines == LineParameters::kEndpoints) {
    return Adjustment<LineEndpointCost>(problem, options).Run(stop, covariances);
  }
  return Adjustment<LineCost>(problem, options).Run(stop, covariances);
}

}  // namespace plslam
