// SPDX-License-Identifier: BSD-3-Clause
// Analytic residuals and Jacobians of our solvers against automatic derivatives of the reference cost functions.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/optim/bundle/line_cost.h"
#include "core/optim/bundle/line_endpoint_cost.h"
#include "core/optim/bundle/point_cost.h"
#include "core/optim/bundle/relative_poses.h"
#include "core/optim/pose_graph/pose_graph_group.h"
#include "core/optim/reference/line_endpoint_functor.h"
#include "core/optim/reference/line_functor.h"
#include "core/optim/reference/motion_functor.h"
#include "core/optim/reference/point_functor.h"
#include "tests/unit/optim/bundle_world.h"
#include "tests/unit/reference/auto_jacobian.h"

namespace plslam {
namespace {

constexpr double kTolerance = 1e-9;

/// The largest difference, relative to numbers above 1.
double LargestDifference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return ((a - b).array().abs() / (1.0 + b.array().abs())).maxCoeff();
}

test::BundleWorld MakeWorld(uint32_t seed) {
  test::BundleWorldSpec spec;
  spec.points = 1;
  spec.lines = 1;
  spec.without_disparity = seed % 2 == 0 ? 0.0 : 1.0;
  return test::MakeBundleWorld(spec, seed);
}

AdjustedPose MovedPose(const SE3& T_w_c) {
  AdjustedPose pose(T_w_c, 0);
  pose.x << 0.01, -0.02, 0.03, 0.2, -0.15, 0.1;
  pose.Update();
  return pose;
}

/// The poses of a world at `seed`, away from where the parameters start; the landmark moves by centimetres.
template <class Cost, class Functor>
void ExpectEqual(const Cost& cost, const AdjustedPose& pose, typename Cost::Landmark landmark, const Functor& functor,
                 uint32_t seed, int& checked) {
  constexpr int kSize = Cost::Landmark::kSize;
  for (int i = 0; i < kSize; ++i) landmark.x(i) += 0.02 * std::sin(1.0 + i);
  const int rows = cost.rows();
  ASSERT_EQ(rows, functor.rows()) << "seed " << seed;
  Eigen::VectorXd r(rows);
  test::RowMajor by_pose(rows, 6);
  test::RowMajor by_landmark(rows, kSize);
  const bool front = cost.Evaluate(pose.view, landmark.x.data(), r.data(), by_pose.data(), by_landmark.data());
  const auto automatic = test::Differentiate<6, kSize>(functor, rows, pose.x.data(), landmark.x.data());
  ASSERT_EQ(front, automatic.ok) << "seed " << seed;
  if (!front) return;
  ++checked;
  EXPECT_LT(LargestDifference(r, automatic.r), kTolerance) << "seed " << seed;
  EXPECT_LT(LargestDifference(by_pose, automatic.by_first), kTolerance) << "seed " << seed;
  EXPECT_LT(LargestDifference(by_landmark, automatic.by_second), kTolerance) << "seed " << seed;
}

TEST(ReferenceCost, Point) {
  int checked = 0;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    const BundleProblem problem = MakeWorld(seed).problem;
    const PointObservation& seen = problem.point_observations[0];
    const SE3& start = problem.poses[static_cast<size_t>(seen.pose)].T_w_c;
    const AdjustedPose pose = MovedPose(start);
    const AdjustedPoint point(problem.points[0]);
    ExpectEqual(PointCost(seen, point, pose.view, problem.camera), pose, point,
                reference::PointFunctor{seen, start, problem.camera}, seed, checked);
  }
  EXPECT_GT(checked, 15);
}

TEST(ReferenceCost, LineOfFourParameters) {
  int checked = 0;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    const BundleProblem problem = MakeWorld(seed).problem;
    const LineObservation& seen = problem.line_observations[0];
    const SE3& start = problem.poses[static_cast<size_t>(seen.pose)].T_w_c;
    const AdjustedPose pose = MovedPose(start);
    const AdjustedLine line(problem.lines[0]);
    reference::LineFunctor functor(seen, {line.start_segment, line.across}, start, problem.camera);
    functor.Anchor(pose.T_w_c(), line.Segment());
    ExpectEqual(LineCost(seen, line, pose.view, problem.camera), pose, line, functor, seed, checked);
  }
  EXPECT_GT(checked, 15);
}

TEST(ReferenceCost, LineOfTwoEndpoints) {
  int checked = 0;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    const BundleProblem problem = MakeWorld(seed).problem;
    const LineObservation& seen = problem.line_observations[0];
    const SE3& start = problem.poses[static_cast<size_t>(seen.pose)].T_w_c;
    const AdjustedPose pose = MovedPose(start);
    const AdjustedEndpoints line(problem.lines[0]);
    // Weights are those of the pose at which the functor is made, parameters count from the start.
    reference::LineEndpointFunctor functor(seen, line.Segment(), pose.T_w_c(), problem.camera);
    functor.start = start;
    ExpectEqual(LineEndpointCost(seen, line, pose.view, problem.camera), pose, line, functor, seed, checked);
  }
  EXPECT_GT(checked, 15);
}

Vector6d RandomVector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vector6d x;
  for (int i = 0; i < 6; ++i) x(i) = normal(random);
  return x;
}

Matrix6d RandomCovariance(std::mt19937& random) {
  Matrix6d root;
  for (int i = 0; i < 6; ++i) root.col(i) = RandomVector(random);
  return root * root.transpose() + Matrix6d::Identity();
}

/// Two poses away from where their parameters start, and a motion between them that differs by `difference`.
struct MovedPair {
  MovedPair(uint32_t seed, double difference) {
    std::mt19937 random(seed);
    start_a = SE3::Exp(RandomVector(random));
    start_b = SE3::Exp(RandomVector(random));
    a = AdjustedPose(start_a, 0);
    b = AdjustedPose(start_b, 1);
    for (AdjustedPose* pose : {&a, &b}) {
      pose->x = 0.2 * RandomVector(random);
      pose->Update();
    }
    measured.T_a_b = a.T_w_c().Inverse() * b.T_w_c() * SE3::Exp(-difference * RandomVector(random));
    measured.covariance = RandomCovariance(random);
  }

  SE3 start_a;
  SE3 start_b;
  AdjustedPose a;
  AdjustedPose b;
  RelativePose measured;
};

// Our Jacobian is to first order in the error (`InverseRightJacobian`): equal to 1e-9 near zero, and of second order
// elsewhere. The residual is exact.
TEST(ReferenceCost, MotionBetweenKeyframes) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    for (const double difference : {1e-6, 1e-2, 0.3}) {
      MovedPair motion(seed, difference);
      const RelativePoseCost cost(motion.measured, motion.a, motion.b);
      ASSERT_TRUE(cost.IsUsable());
      Vector6d r;
      test::RowMajor by_a(6, 6), by_b(6, 6);
      cost.Evaluate(r.data(), by_a.data(), by_b.data());
      const auto automatic =
          test::Differentiate<6, 6>(reference::MotionFunctor(motion.measured, motion.start_a, motion.start_b), 6,
                                    motion.a.x.data(), motion.b.x.data());
      ASSERT_TRUE(automatic.ok);
      EXPECT_LT(LargestDifference(r, automatic.r), kTolerance) << "seed " << seed << " difference " << difference;
      const double tolerance = kTolerance + 5.0 * difference * difference;
      EXPECT_LT(LargestDifference(by_a, automatic.by_first), tolerance) << "seed " << seed << " of " << difference;
      EXPECT_LT(LargestDifference(by_b, automatic.by_second), tolerance) << "seed " << seed << " of " << difference;
    }
  }
}

TEST(ReferenceCost, EdgeInSpace) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    MovedPair motion(seed, 0.5);
    const SE3 a = motion.a.T_w_c();
    const SE3 b = motion.b.T_w_c();
    const Matrix6d information = motion.measured.covariance;
    const Matrix6d U = information.llt().matrixU();
    const PoseEdgeError<SE3> error = PoseGroup<SE3>::Error(motion.measured.T_a_b, a, b);
    // From the right perturbation to the parameters [a; w] at zero.
    const auto by_parameters = [](const SE3& T) {
      Matrix6d by = Matrix6d::Identity();
      by.topLeftCorner<3, 3>() = T.R().transpose();
      return by;
    };
    const Vector6d none = Vector6d::Zero();
    const auto automatic = test::Differentiate<6, 6>(reference::EdgeFunctor(motion.measured.T_a_b, information, a, b),
                                                     6, none.data(), none.data());
    ASSERT_TRUE(automatic.ok);
    EXPECT_LT(LargestDifference(U * error.e, automatic.r), kTolerance) << "seed " << seed;
    EXPECT_LT(LargestDifference(U * error.by_a * by_parameters(a), automatic.by_first), kTolerance)
        << "seed " << seed;
    EXPECT_LT(LargestDifference(U * error.by_b * by_parameters(b), automatic.by_second), kTolerance)
        << "seed " << seed;
  }
}

TEST(ReferenceCost, EdgeInThePlane) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 20; ++round) {
    const double a[] = {normal(random), normal(random), 3.0 * normal(random)};
    const double b[] = {normal(random), normal(random), 3.0 * normal(random)};
    const SE2 T_a_b(normal(random), {normal(random), normal(random)});
    const Eigen::Matrix3d information = RandomCovariance(random).topLeftCorner<3, 3>();
    const Eigen::Matrix3d U = information.llt().matrixU();
    const SE2 pose_a(a[2], {a[0], a[1]}), pose_b(b[2], {b[0], b[1]});
    const PoseEdgeError<SE2> error = PoseGroup<SE2>::Error(T_a_b, pose_a, pose_b);
    const auto by_parameters = [](const SE2& T) {
      Eigen::Matrix3d by = Eigen::Matrix3d::Identity();
      by.topLeftCorner<2, 2>() = T.R().transpose();
      return by;
    };
    const auto automatic = test::Differentiate<3, 3>(
        reference::PlanarEdgeFunctor(T_a_b.angle(), T_a_b.translation(), information), 3, a, b);
    ASSERT_TRUE(automatic.ok);
    EXPECT_LT(LargestDifference(U * error.e, automatic.r), kTolerance) << "round " << round;
    EXPECT_LT(LargestDifference(U * error.by_a * by_parameters(pose_a), automatic.by_first), kTolerance) << round;
    EXPECT_LT(LargestDifference(U * error.by_b * by_parameters(pose_b), automatic.by_second), kTolerance) << round;
  }
}

// The pair that is not ideal is the ideal one at zero, and its disparity and rows move as its parameters promise.
TEST(ReferenceCost, PairOfZerosIsIdeal) {
  const BundleProblem problem = MakeWorld(2).problem;
  const PointObservation& seen = problem.point_observations[0];
  const SE3& start = problem.poses[static_cast<size_t>(seen.pose)].T_w_c;
  reference::PairPointFunctor functor{{seen, start, problem.camera}};
  functor.twist << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6;
  const Vector6d pose = Vector6d::Zero();
  double pair[reference::kPairSize] = {};
  double r[3], ideal[3];
  ASSERT_TRUE(functor(pose.data(), problem.points[0].p_w.data(), pair, r));
  ASSERT_TRUE(functor.ideal(pose.data(), problem.points[0].p_w.data(), ideal));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(r[i], ideal[i], 1e-12) << i;

  const Eigen::Vector3d p_c(0.0, 0.0, 5.0);
  const double turn_rad = 1e-4;
  pair[reference::kTurnY] = turn_rad;
  const reference::PairPixels<double> about_y(problem.camera, pair, functor.twist, p_c);
  const double ideal_right_px = problem.camera.cx_px - problem.camera.FocalBaseline() / 5.0;
  EXPECT_NEAR(about_y.right.x() - ideal_right_px, problem.camera.f_px * turn_rad, 1e-3);
  pair[reference::kTurnY] = 0.0;
  pair[reference::kTurnX] = turn_rad;
  const reference::PairPixels<double> about_x(problem.camera, pair, functor.twist, p_c);
  EXPECT_NEAR(about_x.right.y() - about_x.left.y(), -problem.camera.f_px * turn_rad, 1e-3);
}

}  // namespace
}  // namespace plslam
