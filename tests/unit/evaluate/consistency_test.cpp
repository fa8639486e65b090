// SPDX-License-Identifier: BSD-3-Clause
#include "core/accuracy/consistency.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "tests/unit/evaluate/pairs.h"

namespace plslam::evaluate {
namespace {

Matrix6d MotionCovariance() {
  Matrix6d A = Matrix6d::Zero();
  for (int i = 0; i < 6; ++i) A(i, i) = i < 3 ? 0.01 : 0.001;
  A(0, 4) = 0.004;
  return A * A.transpose();
}

struct Simulation {
  Trajectory estimate;
  std::vector<PoseCovariance> motions;
  std::vector<PoseCovariance> poses;
};

// Simulates estimates whose motions have errors with exactly MotionCovariance: T_true = T * Exp(x).
Simulation Simulate(const Trajectory& truth, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Matrix6d C = MotionCovariance();
  const Matrix6d L = C.llt().matrixL();
  Simulation s{{truth[0]}, {}, {{truth[0].t_ns, Matrix6d::Zero()}}};
  for (size_t i = 1; i < truth.size(); ++i) {
    Vector6d x;
    for (double& value : x) value = normal(random);
    const SE3 motion = truth[i - 1].T_a_b.Inverse() * truth[i].T_a_b * SE3::Exp(L * x).Inverse();
    s.estimate.push_back({truth[i].t_ns, s.estimate.back().T_a_b * motion});
    s.motions.push_back({truth[i].t_ns, C});
    s.poses.push_back({truth[i].t_ns, ComposeCovariance(s.poses.back().covariance, motion, C)});
  }
  return s;
}

TEST(Consistency, HonestMotionCovariancesLieWithinTheBounds) {
  const Trajectory truth = SomePath(2000);
  const Simulation s = Simulate(truth, 1);
  const Consistency c = MotionConsistency(Pair(s.estimate, truth), s.motions);
  EXPECT_EQ(c.n, 1999);
  EXPECT_GT(c.mean_nees, c.lower_bound);
  EXPECT_LT(c.mean_nees, c.upper_bound);
  EXPECT_NEAR(c.above_95_percent, 5.0, 1.5);
}

TEST(Consistency, HonestPoseCovariancesHaveMeanSixOverManyRuns) {
  const Trajectory truth = SomePath(20);
  double sum = 0.0;
  for (uint32_t run = 0; run < 300; ++run) {
    const Simulation s = Simulate(truth, run);
    sum += PoseConsistency(Pair(s.estimate, truth), s.poses).mean_nees;
  }
  EXPECT_NEAR(sum / 300.0, 6.0, 0.4);
}

TEST(Consistency, PoseCovariancesMayStartInTheMiddle) {
  const Trajectory truth = SomePath(20);
  double sum = 0.0;
  for (uint32_t run = 0; run < 300; ++run) {
    Simulation s = Simulate(truth, run);
    s.poses.erase(s.poses.begin(), s.poses.begin() + 8);
    const Consistency c = PoseConsistency(Pair(s.estimate, truth), s.poses);
    EXPECT_EQ(c.n, 11);
    sum += c.mean_nees;
  }
  EXPECT_NEAR(sum / 300.0, 6.0, 0.4);
}

TEST(Consistency, HalvedSigmasQuadrupleNees) {
  const Trajectory truth = SomePath(100);
  Simulation s = Simulate(truth, 3);
  const PosePairs pairs = Pair(s.estimate, truth);
  const double honest = MotionConsistency(pairs, s.motions).mean_nees;
  for (PoseCovariance& row : s.motions) row.covariance *= 0.25;
  EXPECT_NEAR(MotionConsistency(pairs, s.motions).mean_nees, 4.0 * honest, 1e-6 * honest);
}

TEST(Consistency, HonestCovariancesAreHonestOverSpans) {
  const Trajectory truth = SomePath(4000);
  const Simulation s = Simulate(truth, 2);
  const Consistency c = MotionConsistency(Pair(s.estimate, truth), s.motions, 20);
  EXPECT_EQ(c.n, 3980);
  EXPECT_NEAR(c.mean_nees, 6.0, 1.0);
  EXPECT_LT(c.lower_bound, 5.6);
}

TEST(Consistency, ErrorsThatFramesHaveInCommonShowOverSpans) {
  const PosePairs pairs = [] {
    PosePairs all;
    for (int i = 0; i < 100; ++i) all.push_back({i, Translation(i, 0, 0), Translation(1.1 * i, 0, 0), i});
    return all;
  }();
  std::vector<PoseCovariance> motions;
  for (int i = 1; i < 100; ++i) motions.push_back({i, 0.01 * Matrix6d::Identity()});
  const double of_one = MotionConsistency(pairs, motions).mean_nees;
  EXPECT_NEAR(of_one, 1.0, 1e-9);
  EXPECT_NEAR(MotionConsistency(pairs, motions, 20).mean_nees, 20.0 * of_one, 1e-6);
}

TEST(Consistency, OneMotionByHand) {
  const PosePairs pairs{{0, SE3(), SE3(), 0}, {1, Translation(1, 0, 0), Translation(1.2, 0, 0), 1}};
  const Matrix6d C = 0.01 * Matrix6d::Identity();
  const Consistency c = MotionConsistency(pairs, {{1, C}});
  EXPECT_EQ(c.n, 1);
  EXPECT_NEAR(c.mean_nees, 4.0, 1e-9);
}

TEST(Consistency, MotionAcrossALostPoseIsLeftOut) {
  const Trajectory truth = SomePath(10);
  const Simulation s = Simulate(truth, 4);
  PosePairs pairs = Pair(s.estimate, truth);
  pairs.erase(pairs.begin() + 4);
  EXPECT_EQ(MotionConsistency(pairs, s.motions).n, 7);
}

TEST(Consistency, SingularCovariancesAreCounted) {
  const Trajectory truth = SomePath(4);
  const Simulation s = Simulate(truth, 5);
  const std::vector<PoseCovariance> zero{{truth[1].t_ns, Matrix6d::Zero()}, {truth[2].t_ns, Matrix6d::Ones()}};
  const Consistency c = MotionConsistency(Pair(s.estimate, truth), zero);
  EXPECT_EQ(c.n, 0);
  EXPECT_EQ(c.singular, 2);
  EXPECT_EQ(c.mean_nees, 0.0);
}

TEST(Consistency, NothingToCompare) {
  EXPECT_EQ(PoseConsistency({}, {}).n, 0);
  EXPECT_EQ(MotionConsistency(PosePairs(1), {}).n, 0);
}

}  // namespace
}  // namespace plslam::evaluate
