// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/relative_poses.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace plslam {
namespace {

using Jacobian = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

Vector6d RandomVector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vector6d x;
  for (int i = 0; i < 6; ++i) x(i) = normal(random);
  return x;
}

Matrix6d RandomCovariance(std::mt19937& random) {
  Matrix6d root;
  for (int i = 0; i < 6; ++i) root.col(i) = 0.01 * RandomVector(random);
  return root * root.transpose() + 1e-5 * Matrix6d::Identity();
}

/// Two poses anywhere, away from where their parameters start, and a measurement that differs by `difference`.
struct Pair {
  AdjustedPose a;
  AdjustedPose b;
  RelativePose measured;

  Pair(uint32_t seed, bool free_a, bool free_b, double difference) {
    std::mt19937 random(seed);
    a = AdjustedPose(SE3::Exp(RandomVector(random)), free_a ? 0 : -1);
    b = AdjustedPose(SE3::Exp(RandomVector(random)), free_b ? 1 : -1);
    for (AdjustedPose* pose : {&a, &b}) {
      pose->x = 0.2 * RandomVector(random);
      pose->Update();
    }
    const SE3 T_a_b = a.T_w_c().Inverse() * b.T_w_c();
    measured.T_a_b = T_a_b * SE3::Exp(-difference * RandomVector(random));
    measured.covariance = RandomCovariance(random);
  }
};

Vector6d ResidualOf(const RelativePoseCost& cost) {
  Vector6d r;
  cost.Evaluate(r.data(), nullptr, nullptr);
  return r;
}

Matrix6d NumericJacobian(const RelativePoseCost& cost, AdjustedPose& pose) {
  constexpr double kStep = 1e-6;
  Matrix6d numeric;
  for (int i = 0; i < 6; ++i) {
    const double at = pose.x(i);
    pose.x(i) = at + kStep;
    pose.Update();
    const Vector6d plus = ResidualOf(cost);
    pose.x(i) = at - kStep;
    pose.Update();
    const Vector6d minus = ResidualOf(cost);
    pose.x(i) = at;
    pose.Update();
    numeric.col(i) = (plus - minus) / (2.0 * kStep);
  }
  return numeric;
}

struct Freedom {
  bool a;
  bool b;
};

class RelativePoseCostBy : public testing::TestWithParam<Freedom> {};

TEST_P(RelativePoseCostBy, JacobiansAgreeWithNumericOnes) {
  const auto [free_a, free_b] = GetParam();
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    // The Jacobian is of first order in the difference, so its error is of second order.
    for (const double difference : {1e-4, 0.03}) {
      Pair pair(seed, free_a, free_b, difference);
      const RelativePoseCost cost(pair.measured, pair.a, pair.b);
      ASSERT_TRUE(cost.IsUsable());
      Jacobian by_a, by_b;
      Vector6d r;
      cost.Evaluate(r.data(), by_a.data(), by_b.data());
      EXPECT_EQ(r, ResidualOf(cost));
      const double tolerance = 1e-6 + 2.0 * difference * difference;
      if (free_a) {
        const Matrix6d numeric = NumericJacobian(cost, pair.a);
        EXPECT_LT((by_a - numeric).norm(), tolerance * numeric.norm()) << "a, seed " << seed;
      }
      if (free_b) {
        const Matrix6d numeric = NumericJacobian(cost, pair.b);
        EXPECT_LT((by_b - numeric).norm(), tolerance * numeric.norm()) << "b, seed " << seed;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Freedom, RelativePoseCostBy,
                         testing::Values(Freedom{true, true}, Freedom{true, false}, Freedom{false, true}),
                         [](const auto& freedom) {
                           if (freedom.param.a && freedom.param.b) return "BothFree";
                           return freedom.param.a ? "FirstFree" : "SecondFree";
                         });

TEST(RelativePoseCost, UnrequestedJacobiansAreNotWritten) {
  Pair pair(1, true, true, 0.01);
  const RelativePoseCost cost(pair.measured, pair.a, pair.b);
  Vector6d r;
  Jacobian by_a, by_b, expected_a, expected_b;
  cost.Evaluate(r.data(), expected_a.data(), expected_b.data());
  cost.Evaluate(r.data(), by_a.data(), nullptr);
  cost.Evaluate(r.data(), nullptr, by_b.data());
  EXPECT_EQ(by_a, expected_a);
  EXPECT_EQ(by_b, expected_b);
}

TEST(RelativePoseCost, NoResidualAtTheMeasuredPose) {
  Pair pair(3, true, true, 0.0);
  const RelativePoseCost cost(pair.measured, pair.a, pair.b);
  EXPECT_LT(ResidualOf(cost).norm(), 1e-9);
}

// The square of the residual is d^T C^-1 d, with C of the right perturbation of T_a_b.
TEST(RelativePoseCost, SquaresAreMahalanobisDistances) {
  std::mt19937 random(5);
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    Pair pair(seed, true, true, 0.0);
    const Vector6d d = 0.05 * RandomVector(random);
    pair.measured.T_a_b = pair.measured.T_a_b * SE3::Exp(d).Inverse();
    const RelativePoseCost cost(pair.measured, pair.a, pair.b);
    const double expected = d.dot(pair.measured.covariance.inverse() * d);
    EXPECT_NEAR(ResidualOf(cost).squaredNorm(), expected, 1e-6 * expected) << "seed " << seed;
  }
}

TEST(RelativePoseCost, NoiseAsStatedGivesWhiteResiduals) {
  std::mt19937 random(9);
  Pair pair(4, true, true, 0.0);
  const SE3 truth = pair.measured.T_a_b;
  const Matrix6d root = pair.measured.covariance.llt().matrixL();
  Matrix6d sum = Matrix6d::Zero();
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    pair.measured.T_a_b = truth * SE3::Exp(-root * RandomVector(random));
    const Vector6d r = ResidualOf(RelativePoseCost(pair.measured, pair.a, pair.b));
    sum += r * r.transpose();
  }
  EXPECT_LT((sum / kSamples - Matrix6d::Identity()).cwiseAbs().maxCoeff(), 0.05) << sum / kSamples;
}

TEST(RelativePoseCost, InvalidMeasurementsAreRefused) {
  constexpr double kNotFinite = std::numeric_limits<double>::quiet_NaN();
  Pair pair(2, true, true, 0.01);
  const auto usable = [&](const Matrix6d& covariance) {
    RelativePose measured = pair.measured;
    measured.covariance = covariance;
    return RelativePoseCost(measured, pair.a, pair.b).IsUsable();
  };
  EXPECT_TRUE(usable(pair.measured.covariance));
  EXPECT_FALSE(usable(Matrix6d::Zero()));
  EXPECT_FALSE(usable(-pair.measured.covariance));
  EXPECT_FALSE(usable(kNotFinite * Matrix6d::Identity()));
  EXPECT_FALSE(usable(std::numeric_limits<double>::infinity() * Matrix6d::Identity()));
  Matrix6d singular = Matrix6d::Identity();
  singular(3, 3) = 0.0;
  EXPECT_FALSE(usable(singular));
  RelativePose broken = pair.measured;
  broken.T_a_b = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, kNotFinite, 0.0));
  EXPECT_FALSE(RelativePoseCost(broken, pair.a, pair.b).IsUsable());
  Pair fixed(2, false, false, 0.01);
  EXPECT_FALSE(RelativePoseCost(fixed.measured, fixed.a, fixed.b).IsUsable()) << "nothing is free";
  EXPECT_FALSE(RelativePoseCost(pair.measured, pair.a, pair.a).IsUsable()) << "a pose and itself";
}

}  // namespace
}  // namespace plslam
