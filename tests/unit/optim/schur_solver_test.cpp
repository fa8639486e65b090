// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/schur_solver.h"

#include <atomic>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/pose_system.h"
#include "tests/unit/optim/bundle_world.h"

namespace plslam {
namespace {

struct Setting {
  const char* name;
  int points;
  int lines;
  LineParameters parameters;
  bool all_poses_fixed;
};

/// A problem with all that may tie poses and landmarks together, and the two ways to keep its system.
class SolversOf : public testing::TestWithParam<Setting> {
 protected:
  SolversOf() {
    test::BundleWorldSpec spec;
    spec.points = GetParam().points;
    spec.lines = GetParam().lines;
    spec.without_disparity = 0.2;
    spec.outliers = 0.03;
    world_ = test::MakeBundleWorld(spec, 7);
    BundleProblem& problem = world_.problem;
    if (!problem.points.empty()) problem.points[1] = {world_.true_points[1], true};
    if (!problem.lines.empty()) problem.lines[1] = {world_.true_lines[1], true};
    // Poses that see a landmark twice.
    for (size_t i = 0; i < problem.point_observations.size(); i += 50)
      problem.point_observations.push_back(problem.point_observations[i]);
    for (size_t i = 0; i < problem.line_observations.size(); i += 50)
      problem.line_observations.push_back(problem.line_observations[i]);
    const auto count = static_cast<int>(problem.poses.size());
    for (int i = 1; i < count; ++i) {
      const SE3 T_a_b = world_.true_T_w_c[i - 1].Inverse() * world_.true_T_w_c[i];
      problem.relative_poses.push_back({i - 1, i, T_a_b, 1e-4 * Matrix6d::Identity()});
      problem.relative_poses.push_back({i, i - 1, T_a_b.Inverse(), 1e-4 * Matrix6d::Identity()});
    }
    for (BundlePose& pose : problem.poses) pose.fixed |= GetParam().all_poses_fixed;
    options_.lines = GetParam().parameters;
  }

  BundleResult Solve(int max_dense_poses) const {
    BundleOptions options = options_;
    options.max_dense_poses = max_dense_poses;
    return AdjustBundle(world_.problem, options);
  }
  BundleResult SolveDensely() const { return Solve(1000); }
  BundleResult SolveSparsely() const { return Solve(-1); }

  static void ExpectAlike(const BundleResult& a, const BundleResult& b) {
    constexpr double kAlike = 1e-8;
    ASSERT_TRUE(a.ok && b.ok) << a.reason << b.reason;
    EXPECT_EQ(a.iterations, b.iterations);
    EXPECT_EQ(a.point_inliers, b.point_inliers);
    EXPECT_EQ(a.line_inliers, b.line_inliers);
    for (size_t i = 0; i < a.T_w_c.size(); ++i) {
      EXPECT_LT(test::ErrorOf(a.T_w_c[i], b.T_w_c[i]).norm(), kAlike) << "pose " << i;
    }
    for (size_t i = 0; i < a.points.size(); ++i) {
      EXPECT_LT((a.points[i] - b.points[i]).norm(), kAlike * b.points[i].norm()) << "point " << i;
    }
    for (size_t i = 0; i < a.lines.size(); ++i) {
      EXPECT_LT((a.lines[i].p - b.lines[i].p).norm(), kAlike * b.lines[i].p.norm()) << "line " << i;
      EXPECT_LT((a.lines[i].q - b.lines[i].q).norm(), kAlike * b.lines[i].q.norm()) << "line " << i;
    }
  }

  test::BundleWorld world_;
  BundleOptions options_;
};

INSTANTIATE_TEST_SUITE_P(Settings, SolversOf,
                         testing::Values(Setting{"points", 150, 0, LineParameters::kMinimal, false},
                                         Setting{"lines", 0, 80, LineParameters::kMinimal, false},
                                         Setting{"both", 100, 50, LineParameters::kMinimal, false},
                                         Setting{"both_by_endpoints", 100, 50, LineParameters::kEndpoints, false},
                                         Setting{"landmarks_alone", 100, 50, LineParameters::kMinimal, true}),
                         [](const auto& instance) { return instance.param.name; });

// Step for step, with the passes and the outliers of a local adjustment.
TEST_P(SolversOf, SparseIsAsDense) { ExpectAlike(SolveDensely(), SolveSparsely()); }

TEST_P(SolversOf, SparseIsAsDenseToTheEnd) {
  options_.max_iterations = 100;
  options_.max_refinements = 0;
  options_.function_tolerance = 0.0;
  const BundleResult dense = SolveDensely();
  const BundleResult sparse = SolveSparsely();
  ASSERT_TRUE(dense.ok && sparse.ok);
  for (size_t i = 0; i < dense.T_w_c.size(); ++i) {
    EXPECT_LT(test::ErrorOf(dense.T_w_c[i], sparse.T_w_c[i]).norm(), 1e-6) << "pose " << i;
  }
  EXPECT_NEAR(dense.after.normalised, sparse.after.normalised, 1e-8);
}

// Starts so far away that whole steps make it worse.
TEST_P(SolversOf, AgreeFromAFarStart) {
  test::BundleWorldSpec spec;
  spec.points = GetParam().points;
  spec.lines = GetParam().lines;
  spec.start_m = 0.5;
  spec.start_rad = 0.1;
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    world_ = test::MakeBundleWorld(spec, seed);
    for (BundlePose& pose : world_.problem.poses) pose.fixed |= GetParam().all_poses_fixed;
    options_.max_iterations = 25;
    options_.max_refinements = 0;
    const BundleResult dense = SolveDensely();
    const BundleResult sparse = SolveSparsely();
    ASSERT_TRUE(dense.ok && sparse.ok);
    EXPECT_EQ(dense.iterations, sparse.iterations) << "seed " << seed;
    EXPECT_NEAR(dense.after.normalised, sparse.after.normalised, 1e-4 * sparse.after.normalised) << "seed " << seed;
  }
}

/// One pose with a quadratic loss around x = (-1, 0, ...); the effect of steps on "landmarks" is scripted.
class Scripted final : public EliminatedLandmarks {
 public:
  double Linearise(PoseSystem& system) override {
    system.Diagonal(0).setIdentity();
    system.Gradient(0) << 1.0 + pose_.x(0), pose_.x.tail<5>();
    return Bowl();
  }
  bool Eliminate(const Damping& damping, PoseSystem& /*system*/) override {
    dampings.push_back(damping.share);
    return solvable;
  }
  double Step(const Eigen::VectorXd& /*of_poses*/) override { return foretold; }
  void RollBack() override { ++taken_back; }
  double Loss() const override {
    if (on_loss) on_loss();
    return losses_seen_++ < worse_steps ? 10.0 : Bowl();
  }
  double LargestGradient() const override { return 0.0; }

  /// Runs a pass over one free pose.
  BundlePass Run(int max_iterations) {
    BundleOptions options;
    options.max_iterations = max_iterations;
    options.function_tolerance = 0.0;
    const RelativePoses none({}, poses);
    ObservationActions actions{[this] { return LossSum{Bowl(), 1.0}; }, [] { return 0.0; }, [] {}};
    StepControl control(actions, options, &stop);
    EliminatedLandmarks* const nothing = &still_;
    const InertialChain standing({}, poses);
    return SchurSolver(poses, none, standing, {this, nothing}, options).Run(control, false);
  }

  std::vector<AdjustedPose> poses{AdjustedPose(SE3(), 0)};
  std::atomic<bool> stop{false};
  bool solvable = true;
  double foretold = 0.0;
  int worse_steps = 0;
  std::function<void()> on_loss;
  int taken_back = 0;
  std::vector<double> dampings;

 private:
  class Nothing final : public EliminatedLandmarks {
    double Linearise(PoseSystem& /*system*/) override { return 0.0; }
    bool Eliminate(const Damping& /*damping*/, PoseSystem& /*system*/) override { return true; }
    double Step(const Eigen::VectorXd& /*of_poses*/) override { return 0.0; }
    void RollBack() override {}
    double Loss() const override { return 0.0; }
    double LargestGradient() const override { return 0.0; }
  };

  double Bowl() const {
    Vector6d from_bottom = pose_.x;
    from_bottom(0) += 1.0;
    return from_bottom.squaredNorm();
  }

  const AdjustedPose& pose_ = poses.front();
  Nothing still_;
  mutable int losses_seen_ = 0;
};

TEST(SchurSolver, WorseStepsAreRolledBackBitForBit) {
  Scripted scripted;
  scripted.worse_steps = 2;
  const BundlePass pass = scripted.Run(2);
  EXPECT_TRUE(pass.ok);
  EXPECT_EQ(pass.iterations, 2);
  EXPECT_EQ(scripted.taken_back, 2);
  EXPECT_EQ(scripted.poses[0].x, Vector6d::Zero());
  EXPECT_EQ(scripted.poses[0].T_w_c().matrix(), SE3().matrix());
}

TEST(SchurSolver, DampingGrowsAfterAWorseStep) {
  Scripted scripted;
  scripted.worse_steps = 2;
  const BundlePass pass = scripted.Run(30);
  EXPECT_TRUE(pass.ok);
  EXPECT_EQ(scripted.taken_back, 2);
  ASSERT_GT(scripted.dampings.size(), 2U);
  EXPECT_DOUBLE_EQ(scripted.dampings[1], 2.0 * scripted.dampings[0]);
  EXPECT_DOUBLE_EQ(scripted.dampings[2], 8.0 * scripted.dampings[0]);
  EXPECT_NEAR(scripted.poses[0].x(0), -1.0, 1e-6);
}

TEST(SchurSolver, BlockSizesAreTheSameOnEveryProcessor) {
  PoseSystem system(1, PoseSystem::Storage::kDense);
  system.SetZero();
  system.AddToDiagonal(Eigen::VectorXd::Ones(6));
  ASSERT_TRUE(system.Solve());
  EXPECT_EQ(Eigen::l1CacheSize(), 48 * 1024);
}

TEST(SchurSolver, FailsIfTheSystemIsUnsolvable) {
  Scripted scripted;
  scripted.solvable = false;
  const BundlePass pass = scripted.Run(30);
  EXPECT_FALSE(pass.ok);
  EXPECT_EQ(pass.iterations, 5);
  EXPECT_EQ(scripted.poses[0].x, Vector6d::Zero());
}

TEST(SchurSolver, FailsIfTheStepIsNotFinite) {
  Scripted scripted;
  scripted.foretold = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(scripted.Run(30).ok);
  EXPECT_EQ(scripted.poses[0].x, Vector6d::Zero());
}

TEST(SchurSolver, ConvergesIfNoReductionIsPredicted) {
  Scripted scripted;
  scripted.foretold = -10.0;
  const BundlePass pass = scripted.Run(30);
  EXPECT_TRUE(pass.ok);
  EXPECT_EQ(pass.iterations, 5);
  EXPECT_EQ(scripted.poses[0].x, Vector6d::Zero());
}

TEST(SchurSolver, StopsBetweenSteps) {
  Scripted scripted;
  scripted.on_loss = [&scripted] { scripted.stop = true; };
  const BundlePass pass = scripted.Run(30);
  EXPECT_TRUE(pass.ok);
  EXPECT_TRUE(pass.stopped);
  EXPECT_LE(pass.iterations, 2);
  EXPECT_LT(scripted.poses[0].x(0), -0.5) << "the step that was being judged counts";
}

TEST(TrustRegion, GrowsWithGoodStepsAndShrinksFasterAndFaster) {
  TrustRegion region;
  const double start = region.damping().share;
  EXPECT_DOUBLE_EQ(start, 1e-4);
  region.Accepted(1.0);
  EXPECT_DOUBLE_EQ(region.damping().share, start / 3.0);
  region.Accepted(0.5);
  EXPECT_DOUBLE_EQ(region.damping().share, start / 3.0) << "half of what was foretold: neither";
  region.Rejected();
  EXPECT_DOUBLE_EQ(region.damping().share, 2.0 * start / 3.0);
  region.Rejected();
  EXPECT_DOUBLE_EQ(region.damping().share, 8.0 * start / 3.0);
  region.Accepted(0.01);
  EXPECT_GT(region.damping().share, 8.0 * start / 3.0) << "a bad step that gained a little";
  region.Rejected();
  EXPECT_LT(region.damping().share, 40.0 * start / 3.0) << "shrinks by two again";
}

}  // namespace
}  // namespace plslam
