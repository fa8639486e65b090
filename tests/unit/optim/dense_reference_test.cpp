// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/optim/dense_reference.h"

#include <gtest/gtest.h>

#include "tests/unit/optim/bundle_world.h"

namespace plslam {
namespace {

struct Size {
  int points;
  int lines;
  double without_disparity;
};

test::BundleWorld SmallWorld(const Size& size) {
  test::BundleWorldSpec spec;
  spec.fixed_poses = 2;
  spec.free_poses = 3;
  spec.points = size.points;
  spec.lines = size.lines;
  spec.observations = 4;
  spec.without_disparity = size.without_disparity;
  spec.upright = true;
  test::BundleWorld world = test::MakeBundleWorld(spec, 5);
  if (size.points > 0) world.problem.points[1] = {world.true_points[1], true};
  if (size.lines > 0) world.problem.lines[1] = {world.true_lines[1], true};
  return world;
}

// No outlier removal, until convergence.
BundleOptions ToTheEnd() {
  BundleOptions options;
  options.max_iterations = 200;
  options.max_refinements = 0;
  options.function_tolerance = 0.0;
  return options;
}

TEST(AdjustBundle, AgreesWithDenseReference) {
  for (const Size& size : {Size{20, 0, 0.0}, Size{0, 20, 0.0}, Size{12, 10, 0.0}, Size{15, 12, 0.3}}) {
    const test::BundleWorld world = SmallWorld(size);
    const BundleOptions options = ToTheEnd();
    const BundleResult result = AdjustBundle(world.problem, options);
    const test::DenseResult dense = test::AdjustDense(world.problem, options.huber_delta);
    ASSERT_TRUE(result.ok) << result.reason;
    SCOPED_TRACE(testing::Message() << size.points << " points, " << size.lines << " lines, cost " << dense.cost);
    for (size_t i = 0; i < result.T_w_c.size(); ++i) {
      EXPECT_LT(test::ErrorOf(result.T_w_c[i], dense.T_w_c[i]).norm(), 2e-5) << "pose " << i;
    }
    for (size_t i = 0; i < result.points.size(); ++i) {
      EXPECT_LT((result.points[i] - dense.points[i]).norm(), 2e-3) << "point " << i;
    }
    for (size_t i = 0; i < result.lines.size(); ++i) {
      EXPECT_LT((result.lines[i].p - dense.lines[i].p).norm(), 2e-3) << "line " << i;
      EXPECT_LT((result.lines[i].q - dense.lines[i].q).norm(), 2e-3) << "line " << i;
    }
  }
}

// Without robust loss and gate, and with residuals below the sigmas, covariances are the blocks of the inverse of the
// complete information matrix.
TEST(AdjustBundle, PoseCovariancesAgreeWithDenseInverse) {
  const Size size{15, 12, 0.0};
  test::BundleWorld world = SmallWorld(size);
  for (PointObservation& observation : world.problem.point_observations) {
    observation.sigma_px *= 2.0;
    observation.sigma_disparity_px *= 2.0;
  }
  for (LineObservation& observation : world.problem.line_observations) {
    observation.sigma_px *= 2.0;
    observation.sigma_disparity_p_px *= 2.0;
    observation.sigma_disparity_q_px *= 2.0;
  }
  BundleOptions options = ToTheEnd();
  options.huber_delta = 100.0;
  options.gate_sigmas = 10.0;
  const BundleResult result = AdjustBundle(world.problem, options);
  const test::DenseResult dense = test::AdjustDense(world.problem, options.huber_delta);
  ASSERT_TRUE(result.ok) << result.reason;
  int column = 0;
  for (size_t i = 0; i < result.T_w_c.size(); ++i) {
    if (world.problem.poses[i].fixed) {
      EXPECT_TRUE(result.pose_covariances[i].isZero(0.0));
      continue;
    }
    const Matrix6d expected = dense.covariance.block<6, 6>(column, column);
    column += 6;
    EXPECT_LT((result.pose_covariances[i] - expected).norm(), 0.02 * expected.norm())
        << result.pose_covariances[i] << "\n\n"
        << expected;
  }
}

}  // namespace
}  // namespace plslam
