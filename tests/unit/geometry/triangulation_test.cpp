// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/triangulation.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace plslam {
namespace {

const StereoCamera kTriangulating{400.0, 320.0, 240.0, 0.1, 640, 480};

double SmallestEigenvalue(const Eigen::Matrix3d& m) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m).eigenvalues()(0);
}

TEST(Triangulate, SegmentEndpointsProjectBack) {
  const Segment2 left{{100.0, 50.0}, {180.0, 300.0}};
  const UncertainSegment3 s = TriangulateSegment(kTriangulating, left, 12.0, 9.0, 0.5, 5.0, 0.6, 0.7);
  EXPECT_LT((kTriangulating.ProjectStereo(s.segment.p) - Eigen::Vector3d(100.0, 50.0, 12.0)).norm(), 1e-9);
  EXPECT_LT((kTriangulating.ProjectStereo(s.segment.q) - Eigen::Vector3d(180.0, 300.0, 9.0)).norm(), 1e-9);
}

TEST(Triangulate, SlidingIsAlongTheSegmentInSpace) {
  const Segment2 left{{100.0, 50.0}, {180.0, 300.0}};
  const UncertainSegment3 fixed = TriangulateSegment(kTriangulating, left, 12.0, 9.0, 0.5, 0.0, 0.6, 0.7);
  const UncertainSegment3 sliding = TriangulateSegment(kTriangulating, left, 12.0, 9.0, 0.5, 5.0, 0.6, 0.7);
  const Eigen::Vector3d direction = (fixed.segment.q - fixed.segment.p).normalized();
  const Eigen::Matrix3d difference = sliding.covariance_p - fixed.covariance_p;
  EXPECT_GT(difference.norm(), 1e-4);
  EXPECT_LT((difference - difference.trace() * direction * direction.transpose()).norm(), 1e-6 * difference.norm());
}

TEST(Triangulate, SegmentParallelToBaseline) {
  EXPECT_NEAR(AngleToBaseline_rad({{10.0, 5.0}, {90.0, 5.0}}), 0.0, 1e-12);
  EXPECT_NEAR(AngleToBaseline_rad({{90.0, 5.0}, {10.0, 5.0}}), 0.0, 1e-12);
  EXPECT_NEAR(AngleToBaseline_rad({{10.0, 5.0}, {10.0, -50.0}}), std::acos(0.0), 1e-12);
  EXPECT_TRUE(std::isinf(SegmentDisparitySigma_px(0.0, 1.0)));
  EXPECT_NEAR(SegmentDisparitySigma_px(std::acos(0.0), 1.0), std::sqrt(2.0), 1e-12);
}

TEST(FuseGaussian3, EqualsSumOfInformation) {
  Eigen::Matrix3d A;
  A << 0.4, 0.1, 0.0, 0.1, 0.3, 0.05, 0.0, 0.05, 2.0;
  const Eigen::Matrix3d B = Eigen::Vector3d(1.0, 0.2, 0.5).asDiagonal();
  const Gaussian3 a{{1.0, 2.0, 3.0}, A};
  const Gaussian3 b{{1.1, 1.8, 3.6}, B};
  const Eigen::Matrix3d covariance = (A.inverse() + B.inverse()).inverse();
  const Eigen::Vector3d mean = covariance * (A.inverse() * a.mean + B.inverse() * b.mean);
  const Gaussian3 fused = FuseGaussian3(a, b);
  EXPECT_LT((fused.mean - mean).norm(), 1e-12);
  EXPECT_LT((fused.covariance - covariance).norm(), 1e-12);
}

TEST(FuseGaussian3, ExtremesAreSafe) {
  const Gaussian3 exact{{1.0, 2.0, 3.0}, Eigen::Matrix3d::Zero()};
  const Gaussian3 usual{{1.5, 2.0, 3.0}, Eigen::Matrix3d::Identity()};
  const Gaussian3 vague{{9.0, 9.0, 9.0}, 1e14 * Eigen::Matrix3d::Identity()};
  const Gaussian3 broken{{std::nan(""), 0.0, 0.0}, Eigen::Matrix3d::Identity()};
  EXPECT_LT((FuseGaussian3(exact, usual).mean - exact.mean).norm(), 1e-12);
  EXPECT_LT((FuseGaussian3(usual, exact).mean - exact.mean).norm(), 1e-12);
  EXPECT_LT((FuseGaussian3(exact, exact).mean - exact.mean).norm(), 1e-12);
  EXPECT_LT((FuseGaussian3(usual, vague).mean - usual.mean).norm(), 1e-9);
  EXPECT_LT((FuseGaussian3(vague, usual).mean - usual.mean).norm(), 1e-9);
  EXPECT_EQ(FuseGaussian3(usual, broken).mean, usual.mean);
  EXPECT_EQ(FuseGaussian3(broken, usual).mean, usual.mean);
}

UncertainSegment3 MakeSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& q, double variance) {
  return {{p, q}, variance * Eigen::Matrix3d::Identity(), variance * Eigen::Matrix3d::Identity()};
}

TEST(FuseLine, EndpointsMoveAcrossOnly) {
  const UncertainSegment3 old = MakeSegment({0.0, 0.0, 4.0}, {1.0, 0.0, 4.0}, 0.01);
  // The same edge 2 cm lower, cut somewhere else.
  const UncertainSegment3 seen = MakeSegment({-0.5, 0.02, 4.0}, {2.0, 0.02, 4.0}, 0.01);
  const UncertainSegment3 fused = FuseLine(old, seen);
  EXPECT_NEAR(fused.segment.p.x(), 0.0, 1e-12);
  EXPECT_NEAR(fused.segment.q.x(), 1.0, 1e-12);
  EXPECT_GT(fused.segment.p.y(), 0.009);
  EXPECT_LT(fused.segment.p.y(), 0.02);
  EXPECT_LT(fused.covariance_p(1, 1), 0.006);
  // The variance along the line does not change.
  EXPECT_NEAR(fused.covariance_p(0, 0), 0.01, 1e-12);
}

TEST(FuseLine, CorrelatedDepthDoesNotDragEndpoints) {
  UncertainSegment3 old = MakeSegment({0.0, 0.0, 4.0}, {1.0, 0.0, 4.0}, 0.0001);
  const Eigen::Vector3d ray = Eigen::Vector3d(1.0, 0.5, 4.0).normalized();
  old.covariance_q += 0.04 * ray * ray.transpose();
  const UncertainSegment3 fused = FuseLine(old, MakeSegment({0.0, 0.0, 4.3}, {1.0, 0.0, 4.3}, 0.0001));
  EXPECT_NEAR(fused.segment.q.x(), 1.0, 1e-12);
  EXPECT_GT(fused.segment.q.z(), 4.2);
  EXPECT_GT(SmallestEigenvalue(fused.covariance_q), 0.0);
}

TEST(FuseLine, ExtrapolationIsUncertain) {
  const UncertainSegment3 old = MakeSegment({0.0, 0.0, 4.0}, {10.0, 0.0, 4.0}, 0.01);
  const UncertainSegment3 fused = FuseLine(old, MakeSegment({0.0, 0.05, 4.0}, {0.5, 0.05, 4.0}, 0.01));
  EXPECT_GT(fused.segment.p.y(), 0.02);
  EXPECT_LT(fused.segment.q.y(), 0.001);
}

TEST(FuseLine, BrokenObservationChangesNothing) {
  const UncertainSegment3 old = MakeSegment({0.0, 0.0, 4.0}, {1.0, 0.0, 4.0}, 0.01);
  UncertainSegment3 broken = MakeSegment({0.0, 0.0, 4.0}, {0.0, 0.0, 4.0}, 0.01);
  EXPECT_EQ(FuseLine(old, broken).segment.p, old.segment.p);
  broken = MakeSegment({0.0, 0.0, 4.0}, {1.0, std::nan(""), 4.0}, 0.01);
  EXPECT_EQ(FuseLine(old, broken).segment.q, old.segment.q);
}

}  // namespace
}  // namespace plslam
