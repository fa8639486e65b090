#include "core/motion/normal_equations.h"

#include <algorithm>
#include <limits>

namespace plslam {
namespace {

// Squared deviation charged for what has fallen behind the camera, so that hiding an observation never pays.
constexpr double kHidden = 1e4;

template <class Observation, class Prepared>
void PrepareAll(const std::vector<Observation>& observations, const MotionOptions& options,
                std::vector<Prepared>& prepared, std::vector<int>& index) {
  prepared.reserve(observations.size());
  index.reserve(observations.size());
  for (size_t i = 0; i < observations.size(); ++i) {
    const auto one = Prepare(observations[i], options);
    if (!one) continue;
    prepared.push_back(*one);
    index.push_back(static_cast<int>(i));
  }
}

template <int N, class Prepared>
void AddAll(const std::vector<Prepared>& observations, const std::vector<char>& active, const PoseView& view,
            const RobustExpectations& expectations, double delta, NormalEquations& sum) {
  Residual<N> residual;
  for (size_t i = 0; i < observations.size(); ++i) {
    if (active[i] == 0) continue;
    if (!Linearize(observations[i], view, 0.0, residual) || !Whiten(residual)) {
      sum.cost += PseudoHuberLoss(kHidden, delta);
      continue;
    }
    const double squared = residual.r.squaredNorm();
    const double weight = PseudoHuberWeight(squared, delta);
    for (int row = 0; row < N; ++row) {
      const Vector6d J = residual.J.row(row);
      const Vector6d weighted = weight * J;
      for (int column = 0; column < 6; ++column) sum.H_data.col(column) += J(column) * weighted;
      sum.g += residual.r(row) * weighted;
    }
    sum.cost += PseudoHuberLoss(squared, delta);
    sum.dimensions += residual.dimension;
    sum.squares += squared;
    sum.weighted_squares += weight * squared;
    const RobustExpectation& expected = expectations[residual.dimension];
    sum.expected_weighted_squares += residual.dimension * expected.A / expected.probability;
    sum.expected_weight += residual.dimension * expected.weight;
    sum.expected_A += residual.dimension * expected.A;
    sum.expected_B += residual.dimension * expected.B;
  }
}

template <int N, class Prepared>
std::vector<Deviation> Deviations(const std::vector<Prepared>& observations, const PoseView& view,
                                  const MotionOptions& options) {
  Deviation by_dimension[5];
  for (int d = 2; d <= 4; ++d) {
    by_dimension[d] = {0.0, ChiSquareQuantile(d, 0.0), ChiSquareQuantile(d, options.gate_sigmas)};
  }
  std::vector<Deviation> deviations;
  deviations.reserve(observations.size());
  Residual<N> residual;
  for (const Prepared& observation : observations) {
    const bool seen = Linearize(observation, view, options.min_scale_px, residual) && Whiten(residual);
    Deviation deviation = by_dimension[seen ? residual.dimension : N];
    deviation.squared = seen ? residual.r.squaredNorm() : std::numeric_limits<double>::infinity();
    deviations.push_back(deviation);
  }
  return deviations;
}

int Count(const std::vector<char>& flags) { return static_cast<int>(std::count(flags.begin(), flags.end(), 1)); }

}  // namespace

PreparedObservations::PreparedObservations(const std::vector<PointObservation>& point_observations,
                                           const std::vector<LineObservation>& line_observations,
                                           const MotionOptions& options) {
  PrepareAll(point_observations, options, points, point_index);
  PrepareAll(line_observations, options, lines, line_index);
}

int ActiveSet::CountPoints() const { return Count(points); }
int ActiveSet::CountLines() const { return Count(lines); }

NormalEquations BuildNormalEquations(const PreparedObservations& observations, const ActiveSet& active,
                                     const SE3& T_cur_ref, const StereoCamera& camera,
                                     const RobustExpectations& expectations, const MotionOptions& options) {
  const PoseView view(T_cur_ref, camera);
  NormalEquations sum;
  AddAll<3>(observations.points, active.points, view, expectations, options.huber_delta, sum);
  AddAll<4>(observations.lines, active.lines, view, expectations, options.huber_delta, sum);
  return sum;
}

std::vector<Deviation> PointDeviations(const PreparedObservations& observations, const SE3& T_cur_ref,
                                       const StereoCamera& camera, const MotionOptions& options) {
  return Deviations<3>(observations.points, PoseView(T_cur_ref, camera), options);
}

std::vector<Deviation> LineDeviations(const PreparedObservations& observations, const SE3& T_cur_ref,
                                      const StereoCamera& camera, const MotionOptions& options) {
  return Deviations<4>(observations.lines, PoseView(T_cur_ref, camera), options);
}

}  // namespace plslam
