// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include <gtest/gtest.h>

#include "core/optim/bundle/bundle.h"
#include "tests/unit/optim/bundle_world.h"

namespace plslam {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Parameters of lines, and free poses above which their system is sparse.
class AdjustBundleDegenerate : public testing::TestWithParam<std::tuple<LineParameters, int>> {
 protected:
  AdjustBundleDegenerate() { std::tie(options_.lines, options_.max_dense_poses) = GetParam(); }

  static test::BundleWorld Make() {
    test::BundleWorldSpec spec;
    spec.points = 100;
    spec.lines = 30;
    return test::MakeBundleWorld(spec, 7);
  }

  // Checks the invariants of a result, and that poses stay near the truth.
  BundleResult Adjust(const test::BundleWorld& world) const {
    BundleResult result = AdjustBundle(world.problem, options_);
    EXPECT_TRUE(result.ok) << result.reason;
    for (size_t i = 0; i < result.T_w_c.size(); ++i) {
      EXPECT_LT(test::ErrorOf(result.T_w_c[i], world.true_T_w_c[i]).norm(), 0.05) << "pose " << i;
      EXPECT_TRUE(result.pose_covariances[i].allFinite()) << "pose " << i;
    }
    for (const Eigen::Matrix3d& covariance : result.point_covariances) EXPECT_TRUE(covariance.allFinite());
    for (const Eigen::Matrix3d& covariance : result.line_p_covariances) EXPECT_TRUE(covariance.allFinite());
    for (const Eigen::Matrix3d& covariance : result.line_q_covariances) EXPECT_TRUE(covariance.allFinite());
    return result;
  }

  void ExpectAsGiven(const BundleProblem& problem, const BundleResult& result) const {
    EXPECT_FALSE(result.ok);
    EXPECT_FALSE(result.reason.empty());
    ASSERT_EQ(result.T_w_c.size(), problem.poses.size());
    ASSERT_EQ(result.points.size(), problem.points.size());
    ASSERT_EQ(result.lines.size(), problem.lines.size());
    for (size_t i = 0; i < problem.points.size(); ++i) EXPECT_EQ(result.points[i], problem.points[i].p_w);
    EXPECT_EQ(result.point_inliers, std::vector<bool>(problem.point_observations.size(), false));
    EXPECT_EQ(result.line_inliers, std::vector<bool>(problem.line_observations.size(), false));
    EXPECT_TRUE(result.pose_covariances.empty());
  }

  BundleOptions options_;
};

INSTANTIATE_TEST_SUITE_P(LinesAndSolvers, AdjustBundleDegenerate,
                         testing::Combine(testing::Values(LineParameters::kMinimal, LineParameters::kEndpoints),
                                          testing::Values(1000, 0)));

TEST_P(AdjustBundleDegenerate, EmptyProblem) {
  BundleProblem problem;
  ExpectAsGiven(problem, AdjustBundle(problem, options_));
  problem.camera = Make().problem.camera;
  ExpectAsGiven(problem, AdjustBundle(problem, options_));
}

TEST_P(AdjustBundleDegenerate, AllFixed) {
  test::BundleWorld world = Make();
  for (BundlePose& pose : world.problem.poses) pose.fixed = true;
  for (BundlePoint& point : world.problem.points) point.fixed = true;
  for (BundleLine& line : world.problem.lines) line.fixed = true;
  ExpectAsGiven(world.problem, AdjustBundle(world.problem, options_));
}

TEST_P(AdjustBundleDegenerate, NothingSeen) {
  test::BundleWorld world = Make();
  world.problem.point_observations.clear();
  world.problem.line_observations.clear();
  ExpectAsGiven(world.problem, AdjustBundle(world.problem, options_));
}

TEST_P(AdjustBundleDegenerate, ObservationOfNoPose) {
  test::BundleWorld world = Make();
  world.problem.point_observations[3].pose = 99;
  const BundleResult result = AdjustBundle(world.problem, options_);
  ExpectAsGiven(world.problem, result);
  EXPECT_EQ(result.reason, "point observation 3 is of pose 99 of 8 and point 0 of 100");
}

TEST_P(AdjustBundleDegenerate, PoseThatIsNotFinite) {
  test::BundleWorld world = Make();
  world.problem.poses[4].T_w_c = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(kNan, 0.0, 0.0));
  const BundleResult result = AdjustBundle(world.problem, options_);
  EXPECT_FALSE(result.ok);
  EXPECT_EQ(result.reason, "pose 4 is not finite");
}

TEST_P(AdjustBundleDegenerate, LandmarksAndObservationsThatAreNotFinite) {
  test::BundleWorld world = Make();
  world.problem.points[0].p_w.x() = kNan;
  world.problem.points[1].p_w.z() = kInfinity;
  world.problem.lines[0].segment_w.q.y() = kNan;
  world.problem.point_observations[50].uvd.x() = kInfinity;
  world.problem.point_observations[51].sigma_px = 0.0;
  world.problem.point_observations[52].sigma_disparity_px = kNan;
  world.problem.line_observations[50].observed.p.x() = kNan;
  world.problem.line_observations[51].disparity_q_px = kNan;
  const BundleResult result = Adjust(world);
  for (int i : {0, 4, 5, 9, 50, 51, 52}) EXPECT_FALSE(result.point_inliers[i]) << i;
  for (int i : {0, 4, 50, 51}) EXPECT_FALSE(result.line_inliers[i]) << i;
  for (size_t i = 2; i < result.points.size(); ++i) EXPECT_TRUE(result.points[i].allFinite()) << i;
}

TEST_P(AdjustBundleDegenerate, LandmarksBehindTheCamera) {
  test::BundleWorld world = Make();
  const BundlePoint behind{Eigen::Vector3d(0.5, 0.1, -4.0), false};
  world.problem.points[2] = behind;
  world.problem.lines[2].segment_w = {behind.p_w, behind.p_w + Eigen::Vector3d(0.0, 1.0, -0.5)};
  const BundleResult result = Adjust(world);
  for (int i = 10; i < 15; ++i) {
    EXPECT_FALSE(result.point_inliers[i]);
    EXPECT_FALSE(result.line_inliers[i]);
  }
  EXPECT_EQ(result.points[2], behind.p_w);
  EXPECT_EQ(result.lines[2].p, behind.p_w);
}

// Far beyond any parallax, they constrain only rotations.
TEST_P(AdjustBundleDegenerate, PointsAtInfinity) {
  test::BundleWorld world = Make();
  test::BundleWorldMaker maker(test::BundleWorldSpec{}, 9);
  for (int i = 0; i < 20; ++i) {
    const double z = std::pow(10.0, 2.0 + 0.4 * i);
    world.problem.points[i].p_w = Eigen::Vector3d{maker.Uniform(-0.5, 0.5), maker.Uniform(-0.4, 0.4), 1.0} * z;
    for (int k = 0; k < 5; ++k) {
      PointObservation& observation = world.problem.point_observations[5 * i + k];
      const Eigen::Vector3d p_c = world.true_T_w_c[observation.pose].Inverse() * world.problem.points[i].p_w;
      observation.uvd = world.problem.camera.ProjectStereo(p_c) + 0.5 * maker.GaussVector();
      observation.uvd.z() = i % 3 == 0 ? 0.0 : i % 3 == 1 ? -1.0 : std::abs(observation.uvd.z());
    }
  }
  const BundleResult result = Adjust(world);
  int inliers = 0;
  for (int i = 0; i < 100; ++i) inliers += result.point_inliers[i];
  EXPECT_GT(inliers, 70);
  for (const Eigen::Vector3d& p : result.points) EXPECT_TRUE(p.allFinite());
}

TEST_P(AdjustBundleDegenerate, SegmentThroughTheCameraCentre) {
  test::BundleWorld world = Make();
  const SE3& T_w_c = world.problem.poses[3].T_w_c;
  Segment3& segment_w = world.problem.lines[4].segment_w;
  segment_w = {T_w_c * Eigen::Vector3d(0.2, 0.1, 2.0), T_w_c * Eigen::Vector3d(0.4, 0.2, 4.0)};
  for (int i = 20; i < 25; ++i) world.problem.line_observations[i].pose = 3;
  const BundleResult result = Adjust(world);
  EXPECT_TRUE(result.lines[4].p.allFinite() && result.lines[4].q.allFinite());
}

TEST_P(AdjustBundleDegenerate, SegmentsWithoutLength) {
  test::BundleWorld world = Make();
  world.problem.lines[1].segment_w.q = world.problem.lines[1].segment_w.p;
  world.problem.line_observations[40].observed.q = world.problem.line_observations[40].observed.p;
  const BundleResult result = Adjust(world);
  for (int i : {5, 6, 7, 8, 9, 40}) EXPECT_FALSE(result.line_inliers[i]) << i;
  EXPECT_EQ(result.lines[1].p, world.problem.lines[1].segment_w.p);
}

TEST_P(AdjustBundleDegenerate, PoseThatSeesNothing) {
  test::BundleWorld world = Make();
  const int pose = static_cast<int>(world.problem.poses.size());
  const SE3 T_w_c = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(1.0, 2.0, 3.0));
  world.problem.poses.push_back({T_w_c, false});
  world.true_T_w_c.push_back(T_w_c);
  const BundleResult result = Adjust(world);
  EXPECT_EQ(result.T_w_c[pose].translation(), T_w_c.translation());
  EXPECT_GT(result.pose_covariances[pose].trace(), 1e5);
}

TEST_P(AdjustBundleDegenerate, PoseThatSeesOnePoint) {
  test::BundleWorld world = Make();
  const SE3 T_w_c = world.true_T_w_c[3];
  world.problem.poses.push_back({T_w_c, false});
  world.true_T_w_c.push_back(T_w_c);
  PointObservation observation = world.problem.point_observations[0];
  observation.pose = static_cast<int>(world.problem.poses.size()) - 1;
  observation.uvd = world.problem.camera.ProjectStereo(T_w_c.Inverse() * world.true_points[0]);
  world.problem.point_observations.push_back(observation);
  const BundleResult result = AdjustBundle(world.problem, options_);
  ASSERT_TRUE(result.ok);
  EXPECT_LT(test::ErrorOf(result.T_w_c.back(), T_w_c).norm(), 0.2);
  EXPECT_GT(result.pose_covariances.back().trace(), 10.0);
}

// A pose that observes known points, each three times and far from its projection: it moves to their mean, where none
// agrees.
TEST_P(AdjustBundleDegenerate, PoseWithOutliersOnlyIsUnchanged) {
  test::BundleWorld world = Make();
  const SE3 T_w_c = world.true_T_w_c[3];
  world.problem.poses.push_back({T_w_c, false});
  world.true_T_w_c.push_back(T_w_c);
  for (int i = 0; i < 12; ++i) {
    if (i % 3 == 0) world.problem.points.push_back({world.true_points[i], true});
    PointObservation observation;
    observation.pose = static_cast<int>(world.problem.poses.size()) - 1;
    observation.point = static_cast<int>(world.problem.points.size()) - 1;
    const double turn = 2.0 / 3.0 * std::numbers::pi * i;
    const Eigen::Vector3d wrong_px(30.0 + 15.0 * std::cos(turn), 15.0 * std::sin(turn), 0.0);
    const Eigen::Vector3d& p_w = world.problem.points.back().p_w;
    observation.uvd = world.problem.camera.ProjectStereo(T_w_c.Inverse() * p_w) + wrong_px;
    world.problem.point_observations.push_back(observation);
  }
  const BundleResult result = Adjust(world);
  for (size_t i = result.point_inliers.size() - 12; i < result.point_inliers.size(); ++i) {
    EXPECT_FALSE(result.point_inliers[i]) << i;
  }
  EXPECT_EQ(result.T_w_c.back().matrix(), T_w_c.matrix());
  EXPECT_GT(result.pose_covariances.back().trace(), 1e5);
}

TEST_P(AdjustBundleDegenerate, LandmarkWithoutObservations) {
  test::BundleWorld world = Make();
  world.problem.points.push_back({Eigen::Vector3d(1.0, 2.0, 3.0), false});
  const BundleResult result = Adjust(world);
  EXPECT_EQ(result.points.back(), Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_TRUE(result.point_covariances.back().isZero(0.0));
}

// Undetermined: the depth is unchanged, with a correspondingly large covariance.
TEST_P(AdjustBundleDegenerate, LandmarksSeenOnceWithoutDisparity) {
  test::BundleWorld world = Make();
  PointObservation point = world.problem.point_observations[0];
  LineObservation line = world.problem.line_observations[0];
  point.uvd.z() = -1.0;
  point.point = static_cast<int>(world.problem.points.size());
  line.disparity_p_px = -1.0;
  line.line = static_cast<int>(world.problem.lines.size());
  world.problem.points.push_back({world.true_points[0], false});
  world.problem.lines.push_back({world.true_lines[0], false});
  world.problem.point_observations.push_back(point);
  world.problem.line_observations.push_back(line);
  const BundleResult result = Adjust(world);
  EXPECT_LT((result.points.back() - world.true_points[0]).norm(), 0.2);
  EXPECT_LT(test::DistanceToLine(world.true_lines[0].p, result.lines.back()), 0.2);
  EXPECT_GT(result.point_covariances.back().trace(), 1.0);
}

TEST_P(AdjustBundleDegenerate, IdenticalPoses) {
  test::BundleWorld world = Make();
  // The same camera twice, with the same measurements.
  world.problem.poses.push_back(world.problem.poses[3]);
  world.true_T_w_c.push_back(world.true_T_w_c[3]);
  const int twin = static_cast<int>(world.problem.poses.size()) - 1;
  const std::vector<PointObservation> observations = world.problem.point_observations;
  for (PointObservation observation : observations) {
    if (observation.pose != 3) continue;
    observation.pose = twin;
    world.problem.point_observations.push_back(observation);
  }
  const BundleResult result = Adjust(world);
  EXPECT_LT(test::ErrorOf(result.T_w_c[twin], result.T_w_c[3]).norm(), 0.02);
}

TEST_P(AdjustBundleDegenerate, NoPoseIsFixed) {
  test::BundleWorld world = Make();
  for (BundlePose& pose : world.problem.poses) pose.fixed = false;
  const BundleResult result = Adjust(world);
  EXPECT_EQ(result.T_w_c[0].translation(), world.problem.poses[0].T_w_c.translation());
}

TEST_P(AdjustBundleDegenerate, OnlyPosesAreFree) {
  test::BundleWorld world = Make();
  for (size_t i = 0; i < world.problem.points.size(); ++i) world.problem.points[i] = {world.true_points[i], true};
  for (size_t i = 0; i < world.problem.lines.size(); ++i) world.problem.lines[i] = {{world.true_lines[i]}, true};
  Adjust(world);
}

TEST_P(AdjustBundleDegenerate, OnlyLandmarksAreFree) {
  test::BundleWorld world = Make();
  for (size_t i = 0; i < world.problem.poses.size(); ++i) world.problem.poses[i] = {world.true_T_w_c[i], true};
  const BundleResult result = Adjust(world);
  EXPECT_LT(result.after.normalised, 1.2);
}

}  // namespace
}  // namespace plslam
