// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/motion_estimator.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "tests/support/dense_algebra.h"
#include "tests/unit/motion/motion_world.h"

namespace plslam {
namespace {

using test::ErrorOf;
using test::MotionNoise;
using test::MotionWorld;
using test::MotionWorldMaker;

std::optional<MotionEstimate> Estimate(const MotionWorld& world, const SE3& initial = SE3()) {
  return EstimateMotion(world.points, world.lines, world.camera, initial, std::nullopt, MotionOptions());
}

void ExpectMotion(const MotionWorld& world, double tolerance) {
  const auto estimate = Estimate(world);
  ASSERT_TRUE(estimate);
  EXPECT_LT(ErrorOf(estimate->T_cur_ref, world.T_cur_ref).norm(), tolerance);
}

TEST(EstimateMotion, RecoversExactMotionFromPointsLinesAndBoth) {
  MotionWorldMaker maker(1);
  for (const auto& [n_points, n_lines] : {std::pair(30, 0), std::pair(0, 20), std::pair(20, 10)}) {
    SCOPED_TRACE(testing::Message() << n_points << " points, " << n_lines << " lines");
    ExpectMotion(maker.Make(n_points, n_lines, {}), 1e-6);
  }
}

TEST(EstimateMotion, ScaleComesFromTheRightImage) {
  MotionWorldMaker maker(2);
  MotionWorld world = maker.Make(60, 0, {});
  for (PointCorrespondence& o : world.points) o.uvd.z() = -1.0;
  ExpectMotion(world, 1e-5);
}

struct Case {
  const char* name;
  int n_points;
  int n_lines;
};

void PrintTo(const Case& c, std::ostream* os) { *os << c.name; }

class Calibration : public testing::TestWithParam<Case> {};

// Normalised estimation error squared over many draws of all noises: 6 on average when the covariance is honest.
TEST_P(Calibration, NeesIsSix) {
  constexpr int kTrials = 300;
  MotionWorldMaker maker(11);
  double sum = 0.0;
  for (int i = 0; i < kTrials; ++i) {
    const MotionWorld world = maker.Make(GetParam().n_points, GetParam().n_lines, {0.5, 0.6, 0.4});
    const auto estimate = Estimate(world);
    ASSERT_TRUE(estimate) << "trial " << i;
    const Vector6d error = ErrorOf(estimate->T_cur_ref, world.T_cur_ref);
    sum += test::ChiSquare(error, estimate->covariance);
  }
  RecordProperty("nees", std::to_string(sum / kTrials));
  // Three standard deviations of the mean of 300 chi-squares of 6 (0.6), and 10 % for first-order approximations.
  EXPECT_NEAR(sum / kTrials, 6.0, 1.2);
}

INSTANTIATE_TEST_SUITE_P(EstimateMotion, Calibration,
                         testing::Values(Case{"points", 100, 0}, Case{"lines", 0, 60}, Case{"both", 60, 30}),
                         [](const auto& test) { return test.param.name; });

// Plain Gauss-Newton with numeric derivatives of the same robust cost, over all correspondences.
SE3 SlowEstimate(const MotionWorld& world, const MotionOptions& options) {
  const auto residuals = [&](const SE3& T, const SE3& T_weights) {
    std::vector<double> all;
    for (const PointCorrespondence& o : world.points) {
      const Eigen::Matrix3d J = world.camera.ProjectStereoJacobian(T_weights * o.p_ref) * T_weights.R();
      Eigen::Matrix3d S = J * o.covariance * J.transpose();
      S.diagonal() += Eigen::Vector3d(o.sigma_px, o.sigma_px, o.sigma_disparity_px).cwiseAbs2();
      const Eigen::Matrix3d L = S.llt().matrixL();
      const Eigen::Matrix3d L_inverse = L.inverse();
      const Eigen::Vector3d at_weights = L_inverse * (o.uvd - world.camera.ProjectStereo(T_weights * o.p_ref));
      const double weight = 1.0 / std::sqrt(1.0 + at_weights.squaredNorm() / std::pow(options.huber_delta, 2));
      const Eigen::Vector3d r = std::sqrt(weight) * L_inverse * (o.uvd - world.camera.ProjectStereo(T * o.p_ref));
      all.insert(all.end(), {r.x(), r.y(), r.z()});
    }
    return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<int>(all.size())));
  };
  SE3 T;
  for (int iteration = 0; iteration < 40; ++iteration) {
    const Eigen::VectorXd r = residuals(T, T);
    Eigen::MatrixXd J(r.size(), 6);
    for (int i = 0; i < 6; ++i) {
      const Vector6d x = 1e-6 * Vector6d::Unit(i);
      J.col(i) = (residuals(SE3::Exp(x) * T, T) - residuals(SE3::Exp(-x) * T, T)) / 2e-6;
    }
    const Vector6d step = test::LeastSquares(J, r);
    T = SE3::Exp(-step) * T;
  }
  return T;
}

TEST(EstimateMotion, AgreesWithSlowTwin) {
  MotionWorldMaker maker(5);
  const MotionWorld world = maker.Make(40, 0, {0.4, 0.4, 0.3});
  MotionOptions options;
  options.gate_sigmas = 10.0;
  const auto estimate = EstimateMotion(world.points, {}, world.camera, SE3(), std::nullopt, options);
  ASSERT_TRUE(estimate);
  const Vector6d difference = ErrorOf(estimate->T_cur_ref, SlowEstimate(world, options));
  // A twentieth of the sigma: the iteration stops at a hundredth of it.
  EXPECT_LT(test::ChiSquare(difference, estimate->covariance), 0.05 * 0.05);
}

TEST(EstimateMotion, FortyPercentOutliers) {
  MotionWorldMaker maker(7);
  for (int trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(trial);
    MotionWorld world = maker.Make(100, 50, {0.5, 0.5, 0.3});
    for (int i = 0; i < 40; ++i) world.points[i].uvd = world.camera.ProjectStereo(maker.PointInView(world.camera));
    for (int i = 0; i < 20; ++i) world.lines[i].observed = world.lines[49 - i].observed;
    const auto estimate = Estimate(world);
    ASSERT_TRUE(estimate);
    const Vector6d error = ErrorOf(estimate->T_cur_ref, world.T_cur_ref);
    EXPECT_LT(test::ChiSquare(error, estimate->covariance), 30.0) << error.transpose();
    int wrong_inliers = 0;
    for (int i = 0; i < 40; ++i) wrong_inliers += estimate->point_inliers[i] ? 1 : 0;
    EXPECT_LE(wrong_inliers, 2);
    EXPECT_GE(estimate->n_point_inliers, 50);
    EXPECT_GE(estimate->n_line_inliers, 22);
  }
}

TEST(EstimateMotion, ResidualsPerFeatureTypeInSigmas) {
  MotionWorldMaker maker(5);
  MotionWorld world = maker.Make(400, 200, {0.5, 0.6, 0.4});
  const auto honest = Estimate(world);
  ASSERT_TRUE(honest);
  EXPECT_NEAR(honest->point_deviation, 1.0, 0.1);
  EXPECT_NEAR(honest->line_deviation, 1.0, 0.15);
  for (PointCorrespondence& o : world.points) {
    o.sigma_px *= 0.5;
    o.sigma_disparity_px *= 0.5;
    o.covariance *= 0.25;
  }
  const auto boastful = Estimate(world);
  ASSERT_TRUE(boastful);
  EXPECT_NEAR(boastful->point_deviation, 2.0, 0.2);
  EXPECT_NEAR(boastful->line_deviation, 1.0, 0.15);
  EXPECT_EQ(Estimate(maker.Make(50, 0, {0.5, 0.6, 0.4}))->line_deviation, 0.0);
}

// A wall's edge whose near end the camera passes: in front of it at the initial pose, behind it at the true one. Its
// far part is visible all the same, so it agrees with the others until it is out of view.
TEST(EstimateMotion, LinePassingTheCamera) {
  MotionWorldMaker maker(6);
  MotionWorld world = maker.Make(0, 0, {});
  world.T_cur_ref = SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.02, 0.0, -0.1));
  const MotionNoise noise{0.5, 0.5, 0.0};
  for (int i = 0; i < 200; ++i) {
    world.points.push_back(maker.Observe(world, maker.PointInView(world.camera), noise));
  }
  const double nearest_m = 0.25 * world.camera.baseline_m;
  const Eigen::Vector3d near_end = world.T_cur_ref.Inverse() * Eigen::Vector3d(0.4, 0.3, nearest_m - 0.002);
  const Eigen::Vector3d far_end(0.9, 0.3, 3.0);
  world.lines.push_back(maker.Observe(world, Segment3{0.6 * near_end + 0.4 * far_end, far_end}, noise));
  world.lines.back().segment_ref.p = near_end;
  const SE3 initial = SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.0, 0.0, 0.004)) * world.T_cur_ref;
  ASSERT_GT((initial * near_end).z(), nearest_m);

  const auto estimate = Estimate(world, initial);
  ASSERT_TRUE(estimate);
  EXPECT_FALSE(estimate->line_inliers[0]);
  world.lines.clear();
  const auto without = Estimate(world, initial);
  ASSERT_TRUE(without);
  EXPECT_LT(ErrorOf(estimate->T_cur_ref, without->T_cur_ref).norm(), 1e-4);
}

TEST(EstimateMotion, TooFewFeatures) {
  MotionWorldMaker maker(3);
  for (const auto& [n_points, n_lines] : {std::pair(0, 0), std::pair(1, 0), std::pair(2, 0), std::pair(0, 1),
                                          std::pair(0, 2), std::pair(1, 1), std::pair(7, 0)}) {
    EXPECT_FALSE(Estimate(maker.Make(n_points, n_lines, {}))) << n_points << " points, " << n_lines << " lines";
  }
}

TEST(EstimateMotion, IdenticalImages) {
  MotionWorldMaker maker(4);
  for (const double landmark_px : {0.0, 0.3}) {
    MotionWorld world;
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d p = maker.PointInView(world.camera);
      const Eigen::Vector3d q = p + Eigen::Vector3d(0.5, 0.3 * (i % 5), 0.1);
      world.points.push_back(maker.Observe(world, p, {}));
      world.lines.push_back(maker.Observe(world, Segment3{p, q}, {}));
      world.points.back().covariance = landmark_px * 0.01 * Eigen::Matrix3d::Identity();
    }
    const auto estimate = Estimate(world);
    ASSERT_TRUE(estimate);
    EXPECT_LT(ErrorOf(estimate->T_cur_ref, SE3()).norm(), 1e-8);
    EXPECT_LT(estimate->rms, 1e-6);
    EXPECT_TRUE(estimate->covariance.allFinite());
    EXPECT_GT(estimate->covariance.diagonal().minCoeff(), 1e-10);
    EXPECT_LT(estimate->covariance.diagonal().maxCoeff(), 1e-3);
    EXPECT_EQ(estimate->n_point_inliers, 50);
  }
}

std::vector<PointCorrespondence> CollinearPoints(MotionWorldMaker& maker, const MotionWorld& world) {
  std::vector<PointCorrespondence> points;
  for (int i = 0; i < 30; ++i) {
    points.push_back(maker.Observe(world, Eigen::Vector3d(-1.0 + 0.07 * i, 0.02 * i, 4.0 + 0.03 * i), {}));
  }
  return points;
}

std::vector<LineCorrespondence> ParallelLines(MotionWorldMaker& maker, const MotionWorld& world) {
  std::vector<LineCorrespondence> lines;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d p = maker.PointInView(world.camera);
    lines.push_back(maker.Observe(world, Segment3{p, p + Eigen::Vector3d(0.2, 0.9, 0.1)}, {}));
  }
  return lines;
}

TEST(EstimateMotion, CollinearPointsNeedAPrior) {
  MotionWorldMaker maker(8);
  MotionWorld world = maker.Make(0, 0, {});
  world.points = CollinearPoints(maker, world);
  EXPECT_FALSE(Estimate(world));
  const MotionPrior prior{world.T_cur_ref, 1e-4 * Matrix6d::Identity()};
  const auto estimate = EstimateMotion(world.points, {}, world.camera, SE3(), prior, MotionOptions());
  ASSERT_TRUE(estimate);
  EXPECT_LT(ErrorOf(estimate->T_cur_ref, world.T_cur_ref).norm(), 1e-4);
}

TEST(EstimateMotion, ParallelLinesNeedAPrior) {
  MotionWorldMaker maker(9);
  MotionWorld world = maker.Make(0, 0, {});
  world.lines = ParallelLines(maker, world);
  EXPECT_FALSE(Estimate(world));
  const MotionPrior prior{world.T_cur_ref, 1e-2 * Matrix6d::Identity()};
  const auto estimate = EstimateMotion({}, world.lines, world.camera, SE3(), prior, MotionOptions());
  ASSERT_TRUE(estimate);
  EXPECT_LT(ErrorOf(estimate->T_cur_ref, world.T_cur_ref).norm(), 1e-3);
  // Along the lines only the prior constrains the motion.
  const Eigen::Vector3d along = (world.T_cur_ref.rotation() * Eigen::Vector3d(0.2, 0.9, 0.1)).normalized();
  EXPECT_NEAR(along.dot(estimate->covariance.topLeftCorner<3, 3>() * along), 1e-2, 2e-3);
}

TEST(EstimateMotion, NanIsIgnored) {
  MotionWorldMaker maker(10);
  MotionWorld world = maker.Make(60, 30, {0.3, 0.3, 0.2});
  const double nan = std::nan("");
  world.points[0].uvd.x() = nan;
  world.points[1].p_ref.z() = std::numeric_limits<double>::infinity();
  world.points[2].covariance(1, 1) = nan;
  world.points[3].sigma_px = 0.0;
  world.points[4].sigma_disparity_px = nan;
  world.points[5].covariance = 1e30 * Eigen::Matrix3d::Identity();
  world.points[6].p_ref.z() = -3.0;
  world.lines[0].observed.p.x() = nan;
  world.lines[1].segment_ref.q.y() = nan;
  world.lines[2].segment_ref.q = world.lines[2].segment_ref.p;
  world.lines[3].covariance_q(0, 0) = nan;
  world.lines[4].observed.q = world.lines[4].observed.p;
  const auto estimate = Estimate(world);
  ASSERT_TRUE(estimate);
  EXPECT_LT(ErrorOf(estimate->T_cur_ref, world.T_cur_ref).norm(), 0.05);
  for (int i = 0; i < 7; ++i) EXPECT_FALSE(estimate->point_inliers[i]) << "point " << i;
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(estimate->line_inliers[i]) << "line " << i;
}

TEST(EstimateMotion, UnknownStartOrPriorIsRefused) {
  MotionWorldMaker maker(12);
  const MotionWorld world = maker.Make(30, 0, {});
  const SE3 nowhere(Eigen::Quaterniond::Identity(), {std::nan(""), 0.0, 0.0});
  EXPECT_FALSE(Estimate(world, nowhere));
  const MotionPrior negative{SE3(), -Matrix6d::Identity()};
  EXPECT_FALSE(EstimateMotion(world.points, {}, world.camera, SE3(), negative, MotionOptions()));
}

TEST(EstimateMotion, HugeUncertaintyChangesNothing) {
  MotionWorldMaker maker(13);
  MotionWorld world = maker.Make(60, 0, {0.3, 0.3, 0.2});
  const auto without = Estimate(world);
  PointCorrespondence vague = world.points[0];
  vague.p_ref += Eigen::Vector3d(1.0, 1.0, 2.0);
  vague.covariance = 1e2 * vague.p_ref.squaredNorm() * Eigen::Matrix3d::Identity();
  world.points.push_back(vague);
  const auto with = Estimate(world);
  ASSERT_TRUE(without && with);
  const Vector6d change = ErrorOf(with->T_cur_ref, without->T_cur_ref);
  EXPECT_LT(test::ChiSquare(change, without->covariance), 0.01);
}

TEST(EstimateMotion, SameInputSameBits) {
  MotionWorldMaker maker(14);
  const MotionWorld world = maker.Make(100, 50, {0.5, 0.5, 0.3});
  const auto a = Estimate(world);
  const auto b = Estimate(world);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->T_cur_ref.matrix(), b->T_cur_ref.matrix());
  EXPECT_EQ(a->covariance, b->covariance);
}

}  // namespace
}  // namespace plslam
