// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/config/choices.h"
#include "core/optim/bundle/bundle.h"
#include "core/optim/reference/stereo_pair.h"

namespace plslam::refine {

/// Parameters of the camera that are estimated: none; focal length, principal point and radial distortion; or focal
/// length and principal point together with the pose, the focal length and the time of the right camera relative to the
/// left one (`reference::PairParameter`).
enum class CameraChoice { kFixed, kIntrinsics, kAll };
constexpr auto ChoicesOf(CameraChoice) {
  return std::array{Choice{"fixed", CameraChoice::kFixed}, Choice{"intrinsics", CameraChoice::kIntrinsics},
                    Choice{"all", CameraChoice::kAll}};
}

using PairParameters = std::array<double, reference::kPairSize>;

/// One row of the table of parameters: name and unit, the standard deviation of the weak prior, and the factor by which
/// the shown value is the parameter.
struct PairParameterRow {
  const char* name;
  const char* unit;
  double prior_sigma;
  double shown_per_unit;
};
const std::array<PairParameterRow, reference::kPairSize>& PairParameterRows();

/// Measured difference of the rows of a point observation (right minus left); a sigma below zero: none.
struct RowOffset {
  double offset_px = 0.0;
  double sigma_px = -1.0;
};

/// A batch problem: poses, landmarks and all measurements, of which `*_active` take part.
struct BatchProblem {
  BundleProblem bundle;
  std::vector<char> point_active;
  std::vector<char> line_active;
  /// Same length as the point observations; only used if the right camera is estimated.
  std::vector<RowOffset> row_offsets;
  /// Velocity of the camera at each pose in its own frame, for the time skew; empty: none.
  std::vector<Vector6d> twists;
  PairParameters pair{};
};

constexpr std::array<bool, reference::kPairSize> AllFree() {
  std::array<bool, reference::kPairSize> all{};
  all.fill(true);
  return all;
}

struct BatchOptions {
  CameraChoice camera = CameraChoice::kFixed;
  /// Parameters of the camera that take part, of those of `camera`.
  std::array<bool, reference::kPairSize> pair_free = AllFree();
  int max_iterations = 50;
  int threads = 1;
  /// Memory that the factor of the pose system may take; above it the system is solved by conjugate gradients.
  uint64_t memory_bytes = uint64_t{2} << 30;
  /// Called after each iteration with its number and the cost.
  std::function<void(int iteration, double cost)> progress;
  /// Ends the solve with the best state so far.
  const std::atomic<bool>* stop = nullptr;
};

/// Expected demand of a solve, before it starts. Times are those of one core of 3 GHz.
struct BatchDemand {
  bool iterative = false;
  double memory_mb = 0.0;
  double seconds = 0.0;
};
BatchDemand ExpectedDemand(const BatchProblem& problem, const BatchOptions& options);

/// Squared norms of the residuals of each observation, infinite behind the camera: whitened, and in pixels of the left
/// image (of lines the mean of both ends).
struct BatchFit {
  std::vector<double> points;
  std::vector<double> points_px2;
  std::vector<double> lines;
  std::vector<double> lines_px2;
  std::vector<int> line_rows;
};

/// Evaluates all observations at the given state, lines anchored there.
BatchFit FitOf(const BatchProblem& problem);

struct BatchResult {
  bool ok = false;
  std::string reason;
  std::vector<SE3> T_w_c;
  std::vector<Eigen::Vector3d> points;
  std::vector<Segment3> lines;
  PairParameters pair{};
  /// Residuals of all observations at the end.
  BatchFit after;
  /// Half the robust loss of the active observations and motions.
  double cost_before = 0.0;
  double cost_after = 0.0;
  int iterations = 0;
  double seconds = 0.0;
  bool converged = false;
  bool stopped = false;
};

/// Minimises the robust cost of a batch problem with Ceres and the reference cost functions (core/optim/reference):
/// landmarks are eliminated first, and the pose system is factorised by SuiteSparse, or solved by conjugate gradients
/// with a cluster preconditioner if the factor does not fit. The first pose of each part of the problem that measurements
/// connect is constant.
BatchResult SolveBatch(const BatchProblem& problem, const BatchOptions& options);

/// Parameters of the camera that take part: those of `camera`, of `pair_free`.
std::array<bool, reference::kPairSize> FreeParameters(const BatchOptions& options);

/// Standard deviations of the free parameters of the camera at the present state, as the residuals suggest (SuiteSparseQR);
/// zero for the others, infinite if the problem is singular or too large.
PairParameters PairSigmas(const BatchProblem& problem, const BatchOptions& options);

/// Covariances at the present state of a problem, given the first pose of each part: of the right perturbations of all
/// poses. Empty if the information is singular, or the problem too large for a sparse QR factorisation (SuiteSparseQR)
/// of a minute.
std::vector<Matrix6d> PoseCovariances(const BatchProblem& problem, const BatchOptions& options);

/// Covariances of landmarks given the poses; zero without active observations.
struct LandmarkCovariances {
  std::vector<Eigen::Matrix3d> points;
  std::vector<Eigen::Matrix3d> line_p;
  std::vector<Eigen::Matrix3d> line_q;
};
LandmarkCovariances ConditionalCovariances(const BatchProblem& problem);

}  // namespace plslam::refine
