// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/bundle.h"

#include <atomic>

#include <gtest/gtest.h>

#include "core/motion/robust.h"
#include "tests/support/dense_algebra.h"
#include "tests/unit/optim/bundle_world.h"

namespace plslam {
namespace {

struct Kind {
  const char* name;
  int points;
  int lines;
  LineParameters parameters;
};

class AdjustBundleOf : public testing::TestWithParam<Kind> {
 protected:
  AdjustBundleOf() {
    options_.lines = GetParam().parameters;
    spec_.points = GetParam().points;
    spec_.lines = GetParam().lines;
  }

  BundleOptions options_;
  test::BundleWorldSpec spec_;
};

INSTANTIATE_TEST_SUITE_P(Kinds, AdjustBundleOf,
                         testing::Values(Kind{"points", 200, 0, LineParameters::kMinimal},
                                         Kind{"lines", 0, 120, LineParameters::kMinimal},
                                         Kind{"both", 150, 60, LineParameters::kMinimal},
                                         Kind{"lines_by_endpoints", 0, 120, LineParameters::kEndpoints},
                                         Kind{"both_by_endpoints", 150, 60, LineParameters::kEndpoints}),
                         [](const auto& instance) { return instance.param.name; });

TEST_P(AdjustBundleOf, ExactMeasurementsBringBackTheTruth) {
  spec_.noise_px = 0.0;
  spec_.noise_disparity_px = 0.0;
  spec_.upright = true;
  spec_.start_m = 0.01;
  const test::BundleWorld world = test::MakeBundleWorld(spec_, 1);
  options_.function_tolerance = 0.0;
  options_.max_iterations = 50;
  options_.gate_sigmas = 10.0;
  options_.huber_delta = 100.0;
  const BundleResult result = AdjustBundle(world.problem, options_);
  ASSERT_TRUE(result.ok) << result.reason;
  const test::BundleErrors errors = test::ErrorsOf(world, result);
  EXPECT_LT(errors.translation_m, 1e-5);
  EXPECT_LT(errors.rotation_rad, 1e-5);
  EXPECT_LT(errors.point_m, 1e-4);
  EXPECT_LT(errors.line_m, 1e-3);
  EXPECT_LT(result.after.normalised, 1e-3);
  EXPECT_GT(result.before.normalised, 1.0);
}

TEST_P(AdjustBundleOf, NoisyWorldIsRecovered) {
  const test::BundleWorld world = test::MakeBundleWorld(spec_, 2);
  const BundleResult result = AdjustBundle(world.problem, options_);
  ASSERT_TRUE(result.ok) << result.reason;
  BundleResult start = result;
  for (size_t i = 0; i < start.T_w_c.size(); ++i) start.T_w_c[i] = world.problem.poses[i].T_w_c;
  const test::BundleErrors before = test::ErrorsOf(world, start);
  const test::BundleErrors after = test::ErrorsOf(world, result);
  EXPECT_LT(after.translation_m, 0.4 * before.translation_m);
  EXPECT_LT(after.rotation_rad, 0.4 * before.rotation_rad);
  EXPECT_GT(result.before.normalised, 3.0);
  EXPECT_NEAR(result.after.normalised, 0.85, 0.15);
  if (spec_.points > 0) {
    EXPECT_NEAR(result.after.point_px, 0.6, 0.15);
  }
  if (spec_.lines > 0) {
    // Endpoints beyond the observed part are farther from the observed line.
    EXPECT_NEAR(result.after.line_px, 0.5, 0.2);
  }
}

TEST_P(AdjustBundleOf, PoseErrorsMatchTheirCovariances) {
  double nees = 0.0;
  double poses = 0.0;
  for (uint32_t seed = 100; seed < 140; ++seed) {
    const test::BundleWorld world = test::MakeBundleWorld(spec_, seed);
    const BundleResult result = AdjustBundle(world.problem, options_);
    ASSERT_TRUE(result.ok) << result.reason;
    for (size_t i = 0; i < result.T_w_c.size(); ++i) {
      if (world.problem.poses[i].fixed) continue;
      const Vector6d error = test::ErrorOf(result.T_w_c[i], world.true_T_w_c[i]);
      nees += test::ChiSquare(error, result.pose_covariances[i]);
      poses += 1.0;
    }
  }
  EXPECT_NEAR(nees / poses, 6.0, 1.0);
}

// Given all poses, as their covariances are. Medians: depths of far lines are not quite Gaussian.
TEST_P(AdjustBundleOf, LandmarkErrorsMatchTheirCovariances) {
  spec_.fixed_poses = 8;
  spec_.free_poses = 0;
  spec_.upright = true;
  std::vector<double> points;
  std::vector<double> lines;
  for (uint32_t seed = 200; seed < 210; ++seed) {
    const test::BundleWorld world = test::MakeBundleWorld(spec_, seed);
    const BundleResult result = AdjustBundle(world.problem, options_);
    for (size_t i = 0; i < result.points.size(); ++i) {
      if (result.point_covariances[i].isZero(0.0)) continue;
      const Eigen::Vector3d error = result.points[i] - world.true_points[i];
      points.push_back(test::ChiSquare(error, result.point_covariances[i]));
    }
    for (size_t i = 0; i < result.lines.size(); ++i) {
      if (result.line_p_covariances[i].isZero(0.0)) continue;
      // From the true line to the endpoint, across.
      const Segment3& true_w = world.true_lines[i];
      const Eigen::Vector3d along = (true_w.q - true_w.p).normalized();
      const Eigen::Vector3d from = result.lines[i].p - true_w.p;
      const Eigen::Vector3d error = from - along * along.dot(from);
      const Eigen::Matrix3d covariance = result.line_p_covariances[i] + along * along.transpose();
      lines.push_back(test::ChiSquare(error, covariance));
    }
  }
  if (spec_.points > 0) {
    EXPECT_NEAR(Median(points), 2.37, 0.25);
  }
  if (spec_.lines > 0) {
    EXPECT_NEAR(Median(lines), 1.39, 0.25);
  }
}

TEST_P(AdjustBundleOf, OutliersAreRejected) {
  spec_.outliers = 0.1;
  const test::BundleWorld world = test::MakeBundleWorld(spec_, 3);
  const BundleResult result = AdjustBundle(world.problem, options_);
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_LT(test::ErrorsOf(world, result).translation_m, 0.015);
  const auto count = [](const std::vector<bool>& inliers, const std::vector<bool>& outliers, bool wanted) {
    double n = 0.0;
    double all = 0.0;
    for (size_t i = 0; i < inliers.size(); ++i) {
      n += outliers[i] == wanted && inliers[i];
      all += outliers[i] == wanted;
    }
    return n / std::max(1.0, all);
  };
  if (spec_.points > 0) {
    EXPECT_LT(count(result.point_inliers, world.point_outliers, true), 0.01);
    EXPECT_GT(count(result.point_inliers, world.point_outliers, false), 0.95);
  }
  if (spec_.lines > 0) {
    EXPECT_LT(count(result.line_inliers, world.line_outliers, true), 0.03);
    EXPECT_GT(count(result.line_inliers, world.line_outliers, false), 0.93);
  }
}

TEST_P(AdjustBundleOf, EqualInputGivesEqualOutput) {
  spec_.outliers = 0.05;
  const test::BundleWorld world = test::MakeBundleWorld(spec_, 4);
  for (const int max_dense_poses : {1000, 0}) {
    options_.max_dense_poses = max_dense_poses;
    const BundleResult one = AdjustBundle(world.problem, options_);
    const BundleResult two = AdjustBundle(world.problem, options_);
    ASSERT_TRUE(one.ok && two.ok) << one.reason << two.reason;
    for (size_t i = 0; i < one.T_w_c.size(); ++i) {
      EXPECT_EQ(one.T_w_c[i].matrix(), two.T_w_c[i].matrix());
      EXPECT_EQ(one.pose_covariances[i], two.pose_covariances[i]);
    }
    EXPECT_EQ(one.points, two.points);
    EXPECT_EQ(one.point_covariances, two.point_covariances);
    EXPECT_EQ(one.line_p_covariances, two.line_p_covariances);
    EXPECT_EQ(one.line_inliers, two.line_inliers);
  }
}

TEST_P(AdjustBundleOf, WithoutCovariancesAllElseIsTheSame) {
  const test::BundleWorld world = test::MakeBundleWorld(spec_, 5);
  const BundleResult all = AdjustBundle(world.problem, options_);
  const BundleResult without = AdjustBundle(world.problem, options_, nullptr, BundleCovariances::kNone);
  ASSERT_TRUE(without.ok) << without.reason;
  for (size_t i = 0; i < all.T_w_c.size(); ++i) EXPECT_EQ(without.T_w_c[i].matrix(), all.T_w_c[i].matrix()) << i;
  EXPECT_EQ(without.points, all.points);
  EXPECT_EQ(without.point_inliers, all.point_inliers);
  EXPECT_EQ(without.line_inliers, all.line_inliers);
  EXPECT_EQ(without.after.normalised, all.after.normalised);
  EXPECT_TRUE(without.pose_covariances.empty() && without.point_covariances.empty());
  EXPECT_TRUE(without.line_p_covariances.empty() && without.line_q_covariances.empty());
}

TEST_P(AdjustBundleOf, StopsWithTheBestSoFar) {
  const test::BundleWorld world = test::MakeBundleWorld(spec_, 5);
  const std::atomic<bool> stop = true;
  const BundleResult result = AdjustBundle(world.problem, options_, &stop);
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_TRUE(result.stopped);
  EXPECT_EQ(result.iterations, 0);
  for (size_t i = 0; i < result.T_w_c.size(); ++i) {
    EXPECT_EQ(result.T_w_c[i].translation(), world.problem.poses[i].T_w_c.translation());
    EXPECT_TRUE(result.pose_covariances[i].allFinite());
  }
  const std::atomic<bool> unset = false;
  EXPECT_FALSE(AdjustBundle(world.problem, options_, &unset).stopped);
}

// Endpoints do not move along the line: its ends are not observed.
TEST_P(AdjustBundleOf, EndpointsDoNotWander) {
  const test::BundleWorld world = test::MakeBundleWorld(spec_, 6);
  const BundleResult result = AdjustBundle(world.problem, options_);
  for (size_t i = 0; i < result.lines.size(); ++i) {
    const Segment3& start = world.problem.lines[i].segment_w;
    const Eigen::Vector3d step = start.q - start.p;
    EXPECT_LT(std::abs((result.lines[i].p - start.p).dot(step)), 0.05 * step.squaredNorm()) << i;
    EXPECT_LT(std::abs((result.lines[i].q - start.q).dot(step)), 0.05 * step.squaredNorm()) << i;
  }
}

// The observations in a fixed pose fit from the start, as those of a new landmark do: they constrain the landmark all
// the same, in the first step.
TEST_P(AdjustBundleOf, ExactViewsConstrainTheirLandmarks) {
  spec_.noise_px = 0.0;
  spec_.noise_disparity_px = 0.0;
  spec_.upright = true;
  test::BundleWorld world = test::MakeBundleWorld(spec_, 3);
  for (size_t i = 0; i < world.problem.points.size(); ++i) world.problem.points[i].p_w = world.true_points[i];
  for (size_t i = 0; i < world.problem.lines.size(); ++i) world.problem.lines[i].segment_w = world.true_lines[i];
  for (size_t i = 0; i + 1 < world.problem.poses.size(); ++i) world.problem.poses[i] = {world.true_T_w_c[i], true};
  options_.max_iterations = 1;
  options_.max_refinements = 0;
  options_.huber_delta = 100.0;
  const double before_m =
      (world.problem.poses.back().T_w_c.translation() - world.true_T_w_c.back().translation()).norm();
  const BundleResult result = AdjustBundle(world.problem, options_);
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_LT((result.T_w_c.back().translation() - world.true_T_w_c.back().translation()).norm(), 0.05 * before_m);
  for (size_t i = 0; i < result.points.size(); ++i) {
    EXPECT_LT((result.points[i] - world.true_points[i]).norm(), 0.05 * before_m) << "point " << i;
  }
  for (size_t i = 0; i < result.lines.size(); ++i) {
    EXPECT_LT(test::DistanceToLine(result.lines[i].p, world.true_lines[i]), 0.05 * before_m) << "line " << i;
  }
}

// Enough poses for the sparse solver and the sparse covariances.
TEST(AdjustBundle, HundredPoses) {
  test::BundleWorldSpec spec;
  spec.fixed_poses = 2;
  spec.free_poses = 100;
  spec.points = 5000;
  spec.lines = 500;
  spec.start_m = 0.005;
  spec.start_rad = 0.001;
  const test::BundleWorld world = test::MakeBundleWorld(spec, 8);
  BundleOptions options;
  options.max_dense_poses = 60;
  const BundleResult result = AdjustBundle(world.problem, options);
  ASSERT_TRUE(result.ok) << result.reason;
  double nees = 0.0;
  for (int i = 2; i < 102; ++i) {
    const Vector6d error = test::ErrorOf(result.T_w_c[i], world.true_T_w_c[i]);
    nees += test::ChiSquare(error, result.pose_covariances[i]) / 100.0;
  }
  // One chain, so one sample of its drift.
  EXPECT_LT(nees, 20.0);
  EXPECT_GT(nees, 0.5);
  EXPECT_NEAR(result.after.normalised, 0.85, 0.1);
}

}  // namespace
}  // namespace plslam
