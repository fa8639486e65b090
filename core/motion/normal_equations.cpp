// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/normal_equations.h"

#include <algorithm>
#include <array>
#include <limits>

namespace plslam {
namespace {

// Squared residual charged for a correspondence behind the camera, so that hiding it never lowers the cost.
constexpr double kHidden = 1e4;

template <class Correspondence, class Prepared>
void PrepareAll(const std::vector<Correspondence>& correspondences, const MotionOptions& options,
                std::vector<Prepared>& prepared, std::vector<int>& index) {
  prepared.reserve(correspondences.size());
  index.reserve(correspondences.size());
  for (size_t i = 0; i < correspondences.size(); ++i) {
    const auto one = Prepare(correspondences[i], options);
    if (!one) continue;
    prepared.push_back(*one);
    index.push_back(static_cast<int>(i));
  }
}

// Adds the expectations of `count` residuals of this dimension.
void AddExpected(const RobustExpectation& expected, int dimension, int count, NormalEquations& sum) {
  const int dimensions = dimension * count;
  sum.dimensions += dimensions;
  sum.expected_weighted_squares += dimensions * expected.A / expected.probability;
  sum.expected_weight += dimensions * expected.weight;
  sum.expected_A += dimensions * expected.A;
  sum.expected_B += dimensions * expected.B;
}

void AddLine(const Residual<4>& residual, double delta, NormalEquations& sum) {
  const double squared = residual.r.squaredNorm();
  const double weight = PseudoHuberWeight(squared, delta);
  for (int row = 0; row < 4; ++row) {
    const Vector6d J = residual.J.row(row);
    const Vector6d weighted = weight * J;
    for (int column = 0; column < 6; ++column) sum.H_data.col(column) += J(column) * weighted;
    sum.g += residual.r(row) * weighted;
  }
  sum.cost += PseudoHuberLoss(squared, delta);
  sum.squares += squared;
  sum.weighted_squares += weight * squared;
}

std::vector<Deviation> Deviations(const std::vector<double>& squared_norms, const std::vector<int>& dimensions,
                                  const MotionOptions& options) {
  Deviation by_dimension[5];
  for (int d = 2; d <= 4; ++d) {
    by_dimension[d] = {0.0, ChiSquareQuantile(d, 0.0), ChiSquareQuantile(d, options.gate_sigmas)};
  }
  std::vector<Deviation> deviations;
  deviations.reserve(squared_norms.size());
  for (size_t i = 0; i < squared_norms.size(); ++i) {
    deviations.push_back(by_dimension[dimensions[i]]);
    deviations.back().squared = squared_norms[i];
  }
  return deviations;
}

int CountSet(const std::vector<char>& flags) { return static_cast<int>(std::count(flags.begin(), flags.end(), 1)); }

}  // namespace

PreparedCorrespondences::PreparedCorrespondences(const std::vector<PointCorrespondence>& point_correspondences,
                                                 const std::vector<LineCorrespondence>& line_correspondences,
                                                 const MotionOptions& options) {
  PrepareAll(point_correspondences, options, points, point_index);
  PrepareAll(line_correspondences, options, lines, line_index);
  point_batch = PointBatch(points);
}

int ActiveSet::CountPoints() const { return CountSet(points); }
int ActiveSet::CountLines() const { return CountSet(lines); }

NormalEquations BuildNormalEquations(const PreparedCorrespondences& correspondences, const ActiveSet& active,
                                     const SE3& T_cur_ref, const StereoCamera& camera,
                                     const RobustExpectations& expectations, const MotionOptions& options) {
  const PoseView view(T_cur_ref, camera);
  const double delta = options.huber_delta;
  const double hidden_cost = PseudoHuberLoss(kHidden, delta);
  NormalEquations sum;
  std::array<int, 5> count_by_dimension{};
  correspondences.point_batch.AddTo(active.points, view, delta, hidden_cost, sum, count_by_dimension);
  Residual<4> residual;
  for (size_t i = 0; i < correspondences.lines.size(); ++i) {
    if (active.lines[i] == 0) continue;
    if (Linearize(correspondences.lines[i], view, 0.0, residual) && Whiten(residual)) {
      AddLine(residual, delta, sum);
      ++count_by_dimension[residual.dimension];
    } else {
      sum.cost += hidden_cost;
    }
  }
  for (int d = 2; d <= 4; ++d) AddExpected(expectations[d], d, count_by_dimension[d], sum);
  sum.H_data = Matrix6d(sum.H_data.selfadjointView<Eigen::Lower>());
  return sum;
}

std::vector<Deviation> PointDeviations(const PreparedCorrespondences& correspondences, const SE3& T_cur_ref,
                                       const StereoCamera& camera, const MotionOptions& options) {
  std::vector<int> dimensions;
  dimensions.reserve(correspondences.points.size());
  for (const PreparedPoint& point : correspondences.points) dimensions.push_back(point.has_disparity ? 3 : 2);
  return Deviations(correspondences.point_batch.SquaredNorms(PoseView(T_cur_ref, camera), options.min_scale_px),
                    dimensions, options);
}

std::vector<Deviation> LineDeviations(const PreparedCorrespondences& correspondences, const SE3& T_cur_ref,
                                      const StereoCamera& camera, const MotionOptions& options) {
  const PoseView view(T_cur_ref, camera);
  std::vector<double> squared_norms;
  std::vector<int> dimensions;
  squared_norms.reserve(correspondences.lines.size());
  dimensions.reserve(correspondences.lines.size());
  Residual<4> residual;
  for (const PreparedLine& line : correspondences.lines) {
    const bool seen = Linearize(line, view, options.min_scale_px, residual) && Whiten(residual);
    squared_norms.push_back(seen ? residual.r.squaredNorm() : std::numeric_limits<double>::infinity());
    dimensions.push_back(seen ? residual.dimension : 4);
  }
  return Deviations(squared_norms, dimensions, options);
}

}  // namespace plslam
