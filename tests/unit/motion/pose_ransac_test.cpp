// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/pose_ransac.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/motion/alignment.h"
#include "tests/unit/motion/motion_world.h"

namespace plslam {
namespace {

using test::ErrorOf;
using test::MotionWorld;
using test::MotionWorldMaker;

TEST(AlignPoints, RecoversLargeMotion) {
  const SE3 T_a_b = SE3::Exp((Vector6d() << 3.0, -1.0, 2.0, 1.0, -2.0, 0.5).finished());
  const std::array<Eigen::Vector3d, 3> b{Eigen::Vector3d(1, 0, 3), Eigen::Vector3d(-1, 1, 4),
                                         Eigen::Vector3d(0, -1, 6)};
  const auto estimate = AlignPoints(b, {T_a_b * b[0], T_a_b * b[1], T_a_b * b[2]});
  ASSERT_TRUE(estimate);
  EXPECT_LT((*estimate * T_a_b.Inverse()).Log().norm(), 1e-9);
  EXPECT_FALSE(AlignPoints({b[0], b[1], 0.5 * (b[0] + b[1])}, {b[0], b[1], 0.5 * (b[0] + b[1])}));
}

TEST(AlignLines, RecoversLargeMotionOfCutSegments) {
  const SE3 T_a_b = SE3::Exp((Vector6d() << 3.0, -1.0, 2.0, 1.0, -2.0, 0.5).finished());
  const Segment3 first{{1.0, 0.0, 3.0}, {1.0, 2.0, 3.5}};
  const Segment3 second{{-1.0, 0.5, 4.0}, {0.5, 0.7, 5.0}};
  const auto cut = [&](const Segment3& s, double from, double to) {
    return Segment3{T_a_b * Eigen::Vector3d(s.p + from * (s.q - s.p)),
                    T_a_b * Eigen::Vector3d(s.p + to * (s.q - s.p))};
  };
  const auto estimate = AlignLines(first, second, cut(first, -0.5, 0.7), cut(second, 0.3, 1.4), 0.1);
  ASSERT_TRUE(estimate);
  EXPECT_LT((*estimate * T_a_b.Inverse()).Log().norm(), 1e-9);
  EXPECT_FALSE(AlignLines(first, first, cut(first, 0.0, 1.0), cut(first, 0.0, 1.0), 0.1));
}

// Half of the matches are wrong and the camera has turned by up to half a radian.
MotionWorld WideWorld(MotionWorldMaker& maker, int n_points, int n_lines) {
  MotionWorld world;
  world.T_cur_ref = maker.SmallMotion(1.0, 0.3);
  const test::MotionNoise noise{0.5, 0.5, 0.4};
  while (static_cast<int>(world.points.size()) < n_points) {
    const Eigen::Vector3d p = maker.PointInView(world.camera);
    if ((world.T_cur_ref * p).z() > 1.0) world.points.push_back(maker.Observe(world, p, noise));
  }
  while (static_cast<int>(world.lines.size()) < n_lines) {
    const Eigen::Vector3d p = maker.PointInView(world.camera);
    const Eigen::Vector3d q = p + maker.GaussVector().normalized();
    if (q.z() < 1.0 || (world.T_cur_ref * p).z() < 1.5 || (world.T_cur_ref * q).z() < 1.5) continue;
    world.lines.push_back(maker.Observe(world, Segment3{p, q}, noise));
  }
  for (int i = 0; i < n_points / 2; ++i) {
    world.points[i].uvd = world.camera.ProjectStereo(maker.PointInView(world.camera));
  }
  for (int i = 0; i < n_lines / 2; ++i) world.lines[i].observed = world.lines[n_lines - 1 - i].observed;
  return world;
}

class Ransac : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(Ransac, FindsThePoseAmongOutliers) {
  MotionWorldMaker maker(21);
  for (int trial = 0; trial < 5; ++trial) {
    const MotionWorld world = WideWorld(maker, GetParam().first, GetParam().second);
    const auto estimate = EstimatePoseRansac(world.points, world.lines, world.camera, 15, 3.0, 1);
    ASSERT_TRUE(estimate) << "trial " << trial;
    EXPECT_LT(ErrorOf(*estimate, world.T_cur_ref).norm(), 0.05) << "trial " << trial;
  }
}

INSTANTIATE_TEST_SUITE_P(EstimatePoseRansac, Ransac,
                         testing::Values(std::pair(100, 0), std::pair(0, 60), std::pair(60, 30)));

// A first hypothesis with one inlier in a thousand requires more hypotheses than an int can count.
TEST(EstimatePoseRansac, FirstHypothesisWithFewInliers) {
  MotionWorldMaker maker(23);
  MotionWorld world = WideWorld(maker, 1000, 0);
  for (int i = 500; i < 750; ++i) world.points[i].uvd = world.camera.ProjectStereo(maker.PointInView(world.camera));
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const auto estimate = EstimatePoseRansac(world.points, world.lines, world.camera, 15, 3.0, seed);
    ASSERT_TRUE(estimate) << "seed " << seed;
    EXPECT_LT(ErrorOf(*estimate, world.T_cur_ref).norm(), 0.05) << "seed " << seed;
  }
}

// A wide lens with a short baseline in a hall: disparities of 1 to 4 pixels, so that positions are metres off along
// their rays.
TEST(EstimatePoseRansac, FindsThePoseAmongFarPointsToo) {
  MotionWorldMaker maker(25);
  const test::MotionNoise noise{0.5, 0.2, 0.2};
  int n_found = 0;
  for (uint64_t trial = 0; trial < 20; ++trial) {
    MotionWorld world;
    world.camera = StereoCamera(214.0, 256.0, 256.0, 0.1, 512, 512);
    world.T_cur_ref = maker.SmallMotion(0.5, 0.3);
    const auto far_point = [&] { return Eigen::Vector3d(2.5 * maker.PointInView(world.camera)); };
    while (world.points.size() < 100) {
      const Eigen::Vector3d p = far_point();
      if (!world.camera.InImage(world.camera.Project(world.T_cur_ref * p), 0.0)) continue;
      world.points.push_back(maker.Observe(world, p, noise));
      if (world.points.size() > 30) world.points.back().uvd = world.camera.ProjectStereo(far_point());
    }
    const auto estimate = EstimatePoseRansac(world.points, {}, world.camera, 20, 4.0, trial);
    if (estimate && ErrorOf(*estimate, world.T_cur_ref).tail<3>().norm() < 0.02) ++n_found;
  }
  EXPECT_EQ(n_found, 20);
}

TEST(EstimatePoseRansac, SameSeedSameBits) {
  MotionWorldMaker maker(22);
  const MotionWorld world = WideWorld(maker, 60, 20);
  const auto a = EstimatePoseRansac(world.points, world.lines, world.camera, 15, 3.0, 7);
  const auto b = EstimatePoseRansac(world.points, world.lines, world.camera, 15, 3.0, 7);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->matrix(), b->matrix());
}

TEST(EstimatePoseRansac, NothingToFind) {
  MotionWorldMaker maker(23);
  const MotionWorld world = maker.Make(40, 0, {});
  EXPECT_FALSE(EstimatePoseRansac({}, {}, world.camera, 5, 3.0, 1));
  EXPECT_FALSE(EstimatePoseRansac({world.points[0]}, {}, world.camera, 5, 3.0, 1));
  EXPECT_FALSE(EstimatePoseRansac(world.points, {}, world.camera, 41, 3.0, 1));
  EXPECT_FALSE(EstimatePoseRansac(world.points, {}, world.camera, 5, std::nan(""), 1));
  MotionWorld garbage = world;
  for (PointCorrespondence& o : garbage.points) {
    o.uvd = world.camera.ProjectStereo(maker.PointInView(world.camera));
  }
  EXPECT_FALSE(EstimatePoseRansac(garbage.points, {}, world.camera, 15, 3.0, 1));
}

}  // namespace
}  // namespace plslam
