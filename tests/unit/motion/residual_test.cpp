// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "core/motion/line_residual.h"
#include "tests/unit/motion/motion_world.h"
#include "tests/unit/motion/slow_point_residual.h"

namespace plslam {
namespace {

using test::Linearize;

constexpr double kStep = 1e-6;

// r of a linearisation after the perturbation x of T_ref_cur * Exp(x).
template <int N, class Prepared>
Eigen::Matrix<double, N, 1> ResidualAt(const Prepared& prepared, const SE3& T_cur_ref, const Vector6d& x,
                                       const StereoCamera& camera) {
  Residual<N> residual;
  EXPECT_TRUE(Linearize(prepared, PoseView((T_cur_ref.Inverse() * SE3::Exp(x)).Inverse(), camera), 0.0, residual));
  return residual.r;
}

template <int N, class Prepared>
void ExpectJacobian(const Prepared& prepared, const SE3& T_cur_ref, const StereoCamera& camera) {
  Residual<N> residual;
  ASSERT_TRUE(Linearize(prepared, PoseView(T_cur_ref, camera), 0.0, residual));
  for (int i = 0; i < 6; ++i) {
    const Vector6d x = kStep * Vector6d::Unit(i);
    const Eigen::Matrix<double, N, 1> numeric =
        (ResidualAt<N>(prepared, T_cur_ref, x, camera) - ResidualAt<N>(prepared, T_cur_ref, Vector6d(-x), camera)) /
        (2.0 * kStep);
    EXPECT_LT((residual.J.col(i) - numeric).norm(), 1e-4 * (1.0 + numeric.norm()))
        << "column " << i << ": " << residual.J.col(i).transpose() << " numeric " << numeric.transpose();
  }
}

TEST(PointResidual, JacobianMatchesDifferences) {
  test::MotionWorldMaker maker(1);
  const test::MotionWorld world = maker.Make(20, 0, {1.0, 1.0, 1.0});
  for (PointCorrespondence o : world.points) {
    ExpectJacobian<3>(*Prepare(o, MotionOptions()), world.T_cur_ref, world.camera);
    o.uvd.z() = -1.0;
    ExpectJacobian<3>(*Prepare(o, MotionOptions()), world.T_cur_ref, world.camera);
  }
}

TEST(LineResidual, JacobianMatchesDifferences) {
  test::MotionWorldMaker maker(2);
  const test::MotionWorld world = maker.Make(0, 20, {1.0, 1.0, 1.0});
  for (LineCorrespondence o : world.lines) {
    ExpectJacobian<4>(*Prepare(o, MotionOptions()), world.T_cur_ref, world.camera);
    o.disparity_q_px = -1.0;
    ExpectJacobian<4>(*Prepare(o, MotionOptions()), world.T_cur_ref, world.camera);
  }
}

TEST(LineResidual, IsDistanceToBothObservedLines) {
  test::MotionWorldMaker maker(3);
  const test::MotionWorld world = maker.Make(0, 10, {2.0, 2.0, 1.0});
  for (const LineCorrespondence& o : world.lines) {
    Residual<4> residual;
    ASSERT_TRUE(Linearize(*Prepare(o, MotionOptions()), PoseView(world.T_cur_ref, world.camera), 0.0, residual));
    const Eigen::Vector3d p = world.camera.ProjectStereo(world.T_cur_ref * o.segment_ref.p);
    const Eigen::Vector3d q = world.camera.ProjectStereo(world.T_cur_ref * o.segment_ref.q);
    const Eigen::Vector3d left = LineThrough(o.observed);
    const Eigen::Vector3d right = LineThrough({o.observed.p - Eigen::Vector2d(o.disparity_p_px, 0.0),
                                               o.observed.q - Eigen::Vector2d(o.disparity_q_px, 0.0)});
    EXPECT_NEAR(residual.r(0), left.dot(Eigen::Vector3d(p.x(), p.y(), 1.0)), 1e-9);
    EXPECT_NEAR(residual.r(1), left.dot(Eigen::Vector3d(q.x(), q.y(), 1.0)), 1e-9);
    EXPECT_NEAR(residual.r(2), right.dot(Eigen::Vector3d(p.x() - p.z(), p.y(), 1.0)), 1e-9);
    EXPECT_NEAR(residual.r(3), right.dot(Eigen::Vector3d(q.x() - q.z(), q.y(), 1.0)), 1e-9);
  }
}

// The stated covariance of the residuals against that of many noisy measurements and landmarks.
template <int N, class Correspondence, class Landmark>
void ExpectSampledCovariance(test::MotionWorldMaker& maker, const test::MotionWorld& world, const Landmark& landmark,
                             double tolerance) {
  constexpr int kSamples = 4000;
  const test::MotionNoise noise{0.3, 0.4, 0.2};
  Eigen::Matrix<double, N, N> sampled = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, N> stated = Eigen::Matrix<double, N, N>::Zero();
  for (int i = 0; i < kSamples; ++i) {
    const Correspondence o = maker.Observe(world, landmark, noise);
    Residual<N> residual;
    ASSERT_TRUE(Linearize(*Prepare(o, MotionOptions()), PoseView(world.T_cur_ref, world.camera), 0.0, residual));
    sampled += residual.r * residual.r.transpose() / kSamples;
    stated += residual.S / kSamples;
  }
  EXPECT_LT((sampled - stated).norm(), tolerance * stated.norm()) << "sampled\n" << sampled << "\nstated\n" << stated;
}

TEST(PointResidual, CovarianceMatchesSamples) {
  test::MotionWorldMaker maker(4);
  test::MotionWorld world = maker.Make(0, 0, {});
  ExpectSampledCovariance<3, PointCorrespondence>(maker, world, Eigen::Vector3d(0.3, -0.2, 3.0), 0.06);
}

TEST(LineResidual, CovarianceMatchesSamples) {
  test::MotionWorldMaker maker(5);
  test::MotionWorld world = maker.Make(0, 0, {});
  const Segment3 segment{{0.3, -0.6, 3.0}, {0.6, 0.4, 3.4}};
  ExpectSampledCovariance<4, LineCorrespondence>(maker, world, segment, 0.08);
}

TEST(LineResidual, SlidingEndpointAddsNothing) {
  test::MotionWorldMaker maker(6);
  const test::MotionWorld world = maker.Make(0, 1, {0.5, 0.5, 0.5});
  LineCorrespondence o = world.lines[0];
  Residual<4> before;
  ASSERT_TRUE(Linearize(*Prepare(o, MotionOptions()), PoseView(world.T_cur_ref, world.camera), 0.0, before));
  const Eigen::Vector3d along = (o.segment_ref.q - o.segment_ref.p).normalized();
  o.covariance_p += 4.0 * along * along.transpose();
  Residual<4> after;
  ASSERT_TRUE(Linearize(*Prepare(o, MotionOptions()), PoseView(world.T_cur_ref, world.camera), 0.0, after));
  EXPECT_LT((after.S - before.S).norm(), 1e-9 * before.S.norm());
}

TEST(Whiten, MatchesDenseInverse) {
  test::MotionWorldMaker maker(7);
  const test::MotionWorld world = maker.Make(0, 10, {0.5, 0.7, 0.5});
  for (const LineCorrespondence& o : world.lines) {
    Residual<4> residual;
    ASSERT_TRUE(Linearize(*Prepare(o, MotionOptions()), PoseView(world.T_cur_ref, world.camera), 0.0, residual));
    const Eigen::Matrix4d S = residual.S.selfadjointView<Eigen::Lower>();
    const Matrix6d expected = residual.J.transpose() * S.inverse() * residual.J;
    const double squared = residual.r.dot(S.inverse() * residual.r);
    ASSERT_TRUE(Whiten(residual));
    EXPECT_LT((residual.J.transpose() * residual.J - expected).norm(), 1e-6 * expected.norm());
    EXPECT_NEAR(residual.r.squaredNorm(), squared, 1e-6 * (1.0 + squared));
  }
}

TEST(Whiten, RefusesInvalidCovariances) {
  Residual<3> residual;
  residual.r.setOnes();
  residual.J.setOnes();
  residual.S = -Eigen::Matrix3d::Identity();
  EXPECT_FALSE(Whiten(residual));
  residual.S.setConstant(std::nan(""));
  EXPECT_FALSE(Whiten(residual));
}

}  // namespace
}  // namespace plslam
