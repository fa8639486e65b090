// SPDX-License-Identifier: BSD-3-Clause
// The optimum of our bundle adjustment against that of Ceres with the reference cost functions.
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/optim/bundle_world.h"
#include "tests/unit/reference/reference_window.h"

namespace plslam {
namespace {

class ReferenceBundle : public testing::TestWithParam<LineParameters> {};

// One pass to the end: lines keep the anchors of the start, and no observation is removed.
TEST_P(ReferenceBundle, EndsInTheSameOptimum) {
  const bool endpoints = GetParam() == LineParameters::kEndpoints;
  for (uint32_t seed = 1; seed <= 3; ++seed) {
    test::BundleWorldSpec spec;
    spec.points = 120;
    spec.lines = 40;
    test::BundleWorld world = test::MakeBundleWorld(spec, seed);
    for (int i = 1; i < static_cast<int>(world.problem.poses.size()); ++i) {
      const SE3 T = world.true_T_w_c[static_cast<size_t>(i - 1)].Inverse() * world.true_T_w_c[static_cast<size_t>(i)];
      world.problem.relative_poses.push_back({i - 1, i, T, 1e-4 * Matrix6d::Identity()});
    }
    BundleOptions options;
    options.lines = GetParam();
    options.max_iterations = 200;
    options.max_refinements = 0;
    options.function_tolerance = 1e-14;
    const BundleResult ours = AdjustBundle(world.problem, options);
    ASSERT_TRUE(ours.ok) << ours.reason;
    test::ReferenceWindow reference(world.problem, endpoints, options.huber_delta);
    const double cost_of_ours = reference.CostAt(ours, endpoints);
    test::ReferenceWindow fresh(world.problem, endpoints, options.huber_delta);
    const double cost = fresh.Solve();
    EXPECT_NEAR(cost_of_ours, cost, 1e-6 * cost) << "seed " << seed;
    for (size_t i = 0; i < world.problem.poses.size(); ++i) {
      const Vector6d difference = test::ErrorOf(ours.T_w_c[i], fresh.T_w_c(i));
      EXPECT_LT(difference.norm(), 1e-5) << "seed " << seed << " pose " << i << ": " << difference.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lines, ReferenceBundle,
                         testing::Values(LineParameters::kMinimal, LineParameters::kEndpoints),
                         [](const auto& instance) { return std::string(NameOf(instance.param)); });

}  // namespace
}  // namespace plslam
