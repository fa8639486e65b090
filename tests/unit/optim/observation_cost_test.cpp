// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "core/optim/bundle/line_cost.h"
#include "core/optim/bundle/line_endpoint_cost.h"
#include "core/optim/bundle/observation_group.h"
#include "core/optim/bundle/point_cost.h"
#include "tests/unit/optim/bundle_world.h"

namespace plslam {
namespace {

// An observation of each kind in one world, with or without disparity.
template <class Cost>
struct Sample {
  explicit Sample(bool disparity, uint32_t seed);

  test::BundleWorld world;
  AdjustedPose pose;
  typename Cost::Landmark landmark;
  Cost cost;

 private:
  static typename Cost::Landmark LandmarkOf(const BundleProblem& problem);
  static Cost CostOf(const BundleProblem& problem, const typename Cost::Landmark& landmark, const AdjustedPose& pose);
};

test::BundleWorld MakeWorld(bool disparity, uint32_t seed) {
  test::BundleWorldSpec spec;
  spec.points = 1;
  spec.lines = 1;
  spec.without_disparity = disparity ? 0.0 : 1.0;
  return test::MakeBundleWorld(spec, seed);
}

template <>
AdjustedPoint Sample<PointCost>::LandmarkOf(const BundleProblem& problem) {
  return AdjustedPoint(problem.points[0]);
}
template <>
AdjustedLine Sample<LineCost>::LandmarkOf(const BundleProblem& problem) {
  return AdjustedLine(problem.lines[0]);
}
template <>
AdjustedEndpoints Sample<LineEndpointCost>::LandmarkOf(const BundleProblem& problem) {
  return AdjustedEndpoints(problem.lines[0]);
}

template <class Cost>
Cost Sample<Cost>::CostOf(const BundleProblem& problem, const typename Cost::Landmark& landmark,
                          const AdjustedPose& pose) {
  return Cost(problem.line_observations[0], landmark, pose.view, problem.camera);
}
template <>
PointCost Sample<PointCost>::CostOf(const BundleProblem& problem, const AdjustedPoint& landmark,
                                    const AdjustedPose& pose) {
  return PointCost(problem.point_observations[0], landmark, pose.view, problem.camera);
}

template <class Cost>
Sample<Cost>::Sample(bool disparity, uint32_t seed)
    : world(MakeWorld(disparity, seed)),
      pose(world.problem.poses[0].T_w_c, 0),
      landmark(LandmarkOf(world.problem)),
      cost(CostOf(world.problem, landmark, pose)) {
  // Away from the start, so that the parameters turn with the pose.
  pose.x << 0.01, -0.02, 0.03, 0.2, -0.15, 0.1;
  pose.Update();
  for (int i = 0; i < landmark.x.size(); ++i) landmark.x(i) += 0.02 * std::sin(1.0 + i);
}

template <class Cost>
class ObservationCost : public testing::Test {};

using Costs = testing::Types<PointCost, LineCost, LineEndpointCost>;
TYPED_TEST_SUITE(ObservationCost, Costs);

TYPED_TEST(ObservationCost, JacobiansAgreeWithNumericOnes) {
  constexpr int kSize = TypeParam::Landmark::kSize;
  constexpr int kRows = TypeParam::kMaxRows;
  int checked = 0;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    Sample<TypeParam> s(seed % 2 == 0, seed);
    Eigen::Matrix<double, kRows, 1> r, plus, minus;
    Eigen::Matrix<double, kRows, 6, Eigen::RowMajor> by_pose;
    Eigen::Matrix<double, kRows, kSize, Eigen::RowMajor> by_landmark;
    const auto evaluate = [&](auto& out) {
      return s.cost.Evaluate(s.pose.view, s.landmark.x.data(), out.data(), nullptr, nullptr);
    };
    if (!s.cost.Evaluate(s.pose.view, s.landmark.x.data(), r.data(), by_pose.data(), by_landmark.data())) continue;
    ++checked;
    const int rows = s.cost.rows();
    EXPECT_EQ(rows, seed % 2 == 0 ? kRows : 2);
    const auto expect_column = [&](auto& x, int i, const auto& analytic, auto update) {
      constexpr double kStep = 1e-6;
      const double at = x(i);
      x(i) = at + kStep;
      update();
      ASSERT_TRUE(evaluate(plus));
      x(i) = at - kStep;
      update();
      ASSERT_TRUE(evaluate(minus));
      x(i) = at;
      update();
      for (int row = 0; row < rows; ++row) {
        const double numeric = (plus(row) - minus(row)) / (2.0 * kStep);
        EXPECT_NEAR(analytic(row), numeric, 1e-5 * (1.0 + std::abs(numeric)))
            << "seed " << seed << " parameter " << i << " row " << row;
      }
    };
    for (int i = 0; i < 6; ++i) expect_column(s.pose.x, i, by_pose.col(i).eval(), [&] { s.pose.Update(); });
    for (int i = 0; i < kSize; ++i) expect_column(s.landmark.x, i, by_landmark.col(i).eval(), [] {});
  }
  EXPECT_GT(checked, 15);
}

// Noise as stated gives residuals of unit variance, correlated or not.
TYPED_TEST(ObservationCost, ResidualsAreWhite) {
  constexpr int kRows = TypeParam::kMaxRows;
  Eigen::Matrix<double, kRows, kRows> sum = Eigen::Matrix<double, kRows, kRows>::Zero();
  int count = 0;
  test::BundleWorldSpec spec;
  spec.points = 2000;
  spec.lines = 2000;
  spec.upright = true;
  spec.start_m = 0.0;
  spec.start_rad = 0.0;
  spec.noise_px = 0.05;
  spec.noise_disparity_px = 0.05;
  const test::BundleWorld world = test::MakeBundleWorld(spec, 3);
  const auto add = [&](const auto& given, const auto& observation) {
    const AdjustedPose pose(world.true_T_w_c[observation.pose], -1);
    const typename TypeParam::Landmark landmark(given);
    const TypeParam cost(observation, landmark, pose.view, world.problem.camera);
    Eigen::Matrix<double, kRows, 1> r;
    if (!cost.Evaluate(pose.view, landmark.x.data(), r.data(), nullptr, nullptr)) return;
    sum += r * r.transpose();
    ++count;
  };
  if constexpr (std::is_same_v<TypeParam, PointCost>) {
    for (const PointObservation& observation : world.problem.point_observations)
      add(world.problem.points[observation.point], observation);
  } else {
    for (const LineObservation& observation : world.problem.line_observations)
      add(world.problem.lines[observation.line], observation);
  }
  ASSERT_GT(count, 9000);
  const Eigen::Matrix<double, kRows, kRows> covariance = sum / count;
  // A tenth of sigma is allowed for, of the right ends' own.
  EXPECT_LT((covariance - covariance.Identity()).cwiseAbs().maxCoeff(), 0.06) << covariance;
}

}  // namespace
}  // namespace plslam
