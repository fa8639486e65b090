// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/optim/bundle/bundle.h"
#include "tests/unit/optim/bundle_world.h"

namespace plslam {
namespace {

const StereoCamera kCamera{400.0, 320.0, 240.0, 0.12, 640, 480};

SE3 TrueAt(int k) {
  return SE3(ExpSO3(0.1 * k * Eigen::Vector3d(0.2, 1.0, -0.1)), k * Eigen::Vector3d(0.5, 0.1, 0.3));
}

/// Poses without common landmarks: each observes four points of its own, exactly at their projections.
BundleProblem Strangers(int poses) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  BundleProblem problem;
  problem.camera = kCamera;
  for (int k = 0; k < poses; ++k) {
    Vector6d x;
    for (int i = 0; i < 6; ++i) x(i) = k == 0 ? 0.0 : 0.02 * normal(random);
    problem.poses.push_back({TrueAt(k) * SE3::Exp(x), k == 0});
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d p_c(i % 2 - 0.5, (i > 1 ? 1 : 0) - 0.5, 3.0 + 0.3 * i);
      PointObservation observation;
      observation.pose = k;
      observation.point = static_cast<int>(problem.points.size());
      observation.uvd = kCamera.ProjectStereo(p_c);
      problem.point_observations.push_back(observation);
      problem.points.push_back({problem.poses.back().T_w_c * p_c});
    }
  }
  return problem;
}

RelativePose Between(int a, int b, double sigma) {
  return {a, b, TrueAt(a).Inverse() * TrueAt(b), sigma * sigma * Matrix6d::Identity()};
}

BundleOptions ThoroughOptions() {
  BundleOptions options;
  options.max_iterations = 50;
  options.function_tolerance = 1e-9;
  return options;
}

TEST(AdjustBundleRelative, ChainConstrainsPosesWithNothingInCommon) {
  constexpr int kPoses = 6;
  BundleProblem problem = Strangers(kPoses);
  const BundleResult alone = AdjustBundle(problem, ThoroughOptions());
  for (int k = 1; k < kPoses; ++k) problem.relative_poses.push_back(Between(k - 1, k, 0.01));
  const BundleResult chained = AdjustBundle(problem, ThoroughOptions());
  ASSERT_TRUE(alone.ok && chained.ok) << alone.reason << chained.reason;
  for (int k = 1; k < kPoses; ++k) {
    const auto i = static_cast<size_t>(k);
    EXPECT_GT(test::ErrorOf(alone.T_w_c[i], TrueAt(k)).norm(), 1e-3) << "pose " << k;
    EXPECT_LT(test::ErrorOf(chained.T_w_c[i], TrueAt(k)).norm(), 1e-5) << "pose " << k;
    // Their points went with them.
    for (size_t point = 4 * i; point < 4 * i + 4; ++point) {
      const Eigen::Vector3d uvd = kCamera.ProjectStereo(chained.T_w_c[i].Inverse() * chained.points[point]);
      EXPECT_LT((uvd - problem.point_observations[point].uvd).norm(), 1e-3) << "point " << point;
    }
  }
}

// Each step trades residuals of the observations for residuals of the motions.
TEST(AdjustBundleRelative, StepsThatReduceOnlyMotionResiduals) {
  BundleProblem problem = Strangers(6);
  for (int k = 1; k < 6; ++k) problem.relative_poses.push_back(Between(k - 1, k, 0.01));
  BundleOptions options = ThoroughOptions();
  options.max_refinements = 0;
  for (const int max_dense_poses : {1000, 0}) {
    options.max_dense_poses = max_dense_poses;
    const BundleResult chained = AdjustBundle(problem, options);
    ASSERT_TRUE(chained.ok) << chained.reason;
    EXPECT_GT(chained.iterations, 2);
    for (int k = 1; k < 6; ++k) {
      EXPECT_LT(test::ErrorOf(chained.T_w_c[static_cast<size_t>(k)], TrueAt(k)).norm(), 1e-5) << "pose " << k;
    }
  }
}

TEST(AdjustBundleRelative, TheDefaultNumberOfStepsDoesNearlyAsWell) {
  BundleProblem problem = Strangers(6);
  for (int k = 1; k < 6; ++k) problem.relative_poses.push_back(Between(k - 1, k, 0.01));
  const BundleResult chained = AdjustBundle(problem, BundleOptions());
  ASSERT_TRUE(chained.ok) << chained.reason;
  for (int k = 1; k < 6; ++k) {
    EXPECT_LT(test::ErrorOf(chained.T_w_c[static_cast<size_t>(k)], TrueAt(k)).norm(), 2e-3) << "pose " << k;
  }
}

// Two measurements of one motion that differ by 1 cm, of 1 and 2 cm sigma: the mean has weights 4 and 1.
TEST(AdjustBundleRelative, MeasurementsCountByTheirCovariances) {
  BundleProblem problem = Strangers(2);
  problem.relative_poses = {Between(0, 1, 0.01), Between(0, 1, 0.02)};
  const SE3 off(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.01, 0.0, 0.0));
  problem.relative_poses[1].T_a_b = problem.relative_poses[1].T_a_b * off;
  const BundleResult result = AdjustBundle(problem, ThoroughOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  const Vector6d error = test::ErrorOf(result.T_w_c[1], TrueAt(1));
  EXPECT_NEAR(error(0), 0.002, 1e-4);
  EXPECT_LT(error.tail<5>().norm(), 1e-4);
}

// A covariance that is tight in one direction only constrains that direction.
TEST(AdjustBundleRelative, DirectionsCountEachByItself) {
  BundleProblem problem = Strangers(2);
  problem.relative_poses = {Between(0, 1, 0.01), Between(0, 1, 0.01)};
  problem.relative_poses[1].T_a_b =
      problem.relative_poses[1].T_a_b * SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.01, 0.01, 0.0));
  problem.relative_poses[1].covariance(0, 0) = 1e6;
  const BundleResult result = AdjustBundle(problem, ThoroughOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  const Vector6d error = test::ErrorOf(result.T_w_c[1], TrueAt(1));
  EXPECT_NEAR(error(0), 0.0, 1e-4);
  EXPECT_NEAR(error(1), 0.005, 2e-4);
}

// Strong motions correct a world that noise would distort with points alone; weak ones change nothing.
TEST(AdjustBundleRelative, MotionsWeighAgainstObservations) {
  test::BundleWorldSpec spec;
  spec.points = 60;
  spec.lines = 0;
  const test::BundleWorld world = test::MakeBundleWorld(spec, 11);
  const auto error_with = [&](double sigma) {
    BundleProblem problem = world.problem;
    for (int k = 1; sigma > 0.0 && k < static_cast<int>(problem.poses.size()); ++k) {
      const auto i = static_cast<size_t>(k);
      problem.relative_poses.push_back(
          {k - 1, k, world.true_T_w_c[i - 1].Inverse() * world.true_T_w_c[i], sigma * sigma * Matrix6d::Identity()});
    }
    const BundleResult result = AdjustBundle(problem, ThoroughOptions());
    EXPECT_TRUE(result.ok) << result.reason;
    return test::ErrorsOf(world, result).translation_m;
  };
  const double points_only = error_with(0.0);
  EXPECT_NEAR(error_with(10.0), points_only, 0.01 * points_only);
  EXPECT_LT(error_with(1e-5), 0.02 * points_only);
}

TEST(AdjustBundleRelative, IndefiniteCovariancesAreIgnored) {
  test::BundleWorldSpec spec;
  spec.points = 60;
  spec.lines = 20;
  test::BundleWorld world = test::MakeBundleWorld(spec, 11);
  const BundleResult expected = AdjustBundle(world.problem, BundleOptions());
  Matrix6d indefinite = Matrix6d::Identity();
  indefinite(2, 2) = -1e-3;
  for (const Matrix6d& covariance : {Matrix6d(Matrix6d::Zero()), indefinite, Matrix6d(NAN * Matrix6d::Identity())}) {
    BundleProblem problem = world.problem;
    RelativePose wrong = Between(2, 3, 1.0);
    wrong.covariance = covariance;
    problem.relative_poses.push_back(wrong);
    const BundleResult result = AdjustBundle(problem, BundleOptions());
    ASSERT_TRUE(result.ok) << result.reason;
    for (size_t i = 0; i < result.T_w_c.size(); ++i) {
      EXPECT_EQ(result.T_w_c[i].matrix(), expected.T_w_c[i].matrix()) << "pose " << i;
    }
  }
}

TEST(AdjustBundleRelative, MissingPosesAreNamed) {
  BundleProblem problem = Strangers(2);
  problem.relative_poses = {Between(0, 1, 0.01)};
  problem.relative_poses[0].b = 2;
  const BundleResult result = AdjustBundle(problem, BundleOptions());
  EXPECT_FALSE(result.ok);
  EXPECT_NE(result.reason.find("between poses 0 and 2 of 2"), std::string::npos) << result.reason;
}

TEST(AdjustBundleRelative, OneWrongMotionDoesNotOverruleTheObservations) {
  test::BundleWorldSpec spec;
  spec.points = 200;
  spec.lines = 0;
  const test::BundleWorld world = test::MakeBundleWorld(spec, 11);
  const double before = test::ErrorsOf(world, AdjustBundle(world.problem, ThoroughOptions())).translation_m;
  BundleProblem problem = world.problem;
  RelativePose wrong{3, 4, world.true_T_w_c[3].Inverse() * world.true_T_w_c[4], 1e-4 * Matrix6d::Identity()};
  wrong.T_a_b = wrong.T_a_b * SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(1.0, 0.0, 0.0));
  problem.relative_poses.push_back(wrong);
  const BundleResult result = AdjustBundle(problem, ThoroughOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_LT(test::ErrorsOf(world, result).translation_m, 2.0 * before + 0.005) << "without it " << before;
}

}  // namespace
}  // namespace plslam
