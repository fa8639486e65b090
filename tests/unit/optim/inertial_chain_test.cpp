// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/inertial_chain.h"

#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "tests/unit/inertial/smooth_motion.h"

namespace plslam {
namespace {

constexpr double kInterval_s = 0.3;
const SE3 kT_c_imu(ExpSO3({0.4, -0.2, 0.9}), Eigen::Vector3d(0.05, -0.1, 0.03));
const ImuBias kBias{{0.002, -0.001, 0.003}, {0.05, -0.08, 0.03}};

/// Poses of a camera that moves with an inertial sensor, and what that senses between them, exactly.
class Moving {
 public:
  explicit Moving(int n) {
    for (int i = 0; i < n; ++i)
      problem_.poses.push_back({motion_.Pose(kInterval_s * i) * kT_c_imu.Inverse(), i == 0});
    for (int i = 0; i + 1 < n; ++i) Sense(i, i + 1);
    problem_.gravity.g_w_m_s2 = {0.0, 0.0, -test::SmoothMotion::kGravity};
    problem_.gravity.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  }

  BundleProblem& problem() { return problem_; }

  void Sense(int a, int b) {
    std::vector<ImuSample> samples = motion_.Samples(1000.0, kInterval_s * a, kInterval_s * b);
    for (ImuSample& sample : samples) {
      sample.rate_rad_s += kBias.rate_rad_s;
      sample.force_m_s2 += kBias.force_m_s2;
    }
    // Integrated with a bias that is wrong by what is then estimated.
    const ImuBias integrated{kBias.rate_rad_s, kBias.force_m_s2 + Eigen::Vector3d(0.02, -0.01, 0.01)};
    const auto sensed = Preintegrate(samples, samples.front().t_ns, samples.back().t_ns, ImuNoise(), integrated);
    problem_.inertial_motions.push_back({a, b, kT_c_imu, sensed.value(), {integrated, 1e-5, 0.05}});
  }

  /// The poses of an adjustment, each observed, away from where their parameters start.
  std::vector<AdjustedPose> Poses(double off, uint32_t seed) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, off);
    std::vector<AdjustedPose> poses;
    for (const BundlePose& pose : problem_.poses) {
      const int n_free = CountFree(poses);
      poses.emplace_back(pose.T_w_c, pose.fixed ? -1 : n_free);
      poses.back().observations = 1;
      for (int i = 0; i < 6 && !pose.fixed; ++i) poses.back().x(i) = normal(random);
      poses.back().Update();
    }
    return poses;
  }

 private:
  test::SmoothMotion motion_;
  BundleProblem problem_;
};

double LossAt(const InertialChain& chain, AdjustedPose& pose, int parameter, double step) {
  const double at = pose.x(parameter);
  pose.x(parameter) = at + step;
  pose.Update();
  const double loss = chain.Loss();
  pose.x(parameter) = at;
  pose.Update();
  return loss;
}

TEST(InertialChain, ExactMotionCostsNothing) {
  Moving moving(6);
  std::vector<AdjustedPose> poses = moving.Poses(0.0, 1);
  // The prior of the bias, which is off by less than its sigma, is what remains.
  EXPECT_LT(InertialChain(moving.problem(), poses).Loss(), 0.3);
}

// The gradient of the loss at the best states is that of the loss with its states eliminated.
TEST(InertialChain, GradientAgreesWithNumericOne) {
  for (const double off : {1e-4, 1e-2}) {
    Moving moving(5);
    std::vector<AdjustedPose> poses = moving.Poses(off, 3);
    const InertialChain chain(moving.problem(), poses);
    PoseSystem system(CountFree(poses), PoseSystem::Storage::kDense);
    system.SetZero();
    EXPECT_DOUBLE_EQ(chain.Linearise(system), chain.Loss());
    const double scale = system.g().norm();
    for (AdjustedPose& pose : poses) {
      if (!pose.IsFree()) continue;
      for (int i = 0; i < 6; ++i) {
        constexpr double kStep = 1e-6;
        const double numeric = (LossAt(chain, pose, i, kStep) - LossAt(chain, pose, i, -kStep)) / (2.0 * kStep);
        // Losses are twice the costs. Weights, found by iteration, are not exactly those of the best states.
        EXPECT_NEAR(0.5 * numeric, system.Gradient(pose.column)(i), 0.02 * scale) << "off by " << off;
      }
    }
  }
}

// One Gauss-Newton step from a small error reaches the poses that cost nothing; positions need two more constraints.
TEST(InertialChain, InformationIsThatOfTheLoss) {
  Moving moving(5);
  std::vector<AdjustedPose> poses = moving.Poses(2e-4, 4);
  const InertialChain chain(moving.problem(), poses);
  for (const auto storage : {PoseSystem::Storage::kDense, PoseSystem::Storage::kSparse}) {
    PoseSystem system(CountFree(poses), storage);
    system.SetZero();
    const double before = chain.Linearise(system);
    system.AddToDiagonal(Eigen::VectorXd::Constant(system.g().size(), 1e-3));
    const auto step = system.Solve();
    ASSERT_TRUE(step);
    for (AdjustedPose& pose : poses) {
      if (!pose.IsFree()) continue;
      pose.x += step->segment<6>(6 * pose.column);
      pose.Update();
    }
    EXPECT_LT(chain.Loss(), 0.01 * before + 0.3);
    for (AdjustedPose& pose : poses) {
      if (!pose.IsFree()) continue;
      pose.x -= step->segment<6>(6 * pose.column);
      pose.Update();
    }
  }
}

// A single motion leaves the velocity free; two in a row measure how much the path bends.
TEST(InertialChain, PositionsNeedTwoMotions) {
  for (const int n : {2, 3}) {
    Moving moving(n);
    std::vector<AdjustedPose> poses = moving.Poses(0.0, 1);
    const InertialChain chain(moving.problem(), poses);
    const double bent = LossAt(chain, poses[1], 0, 0.01);
    if (n == 2) {
      EXPECT_LT(bent, 0.3);
    } else {
      EXPECT_GT(bent, 10.0);
    }
  }
}

TEST(InertialChain, GravityHoldsTheVertical) {
  Moving moving(6);
  std::vector<AdjustedPose> poses = moving.Poses(0.0, 1);
  const InertialChain chain(moving.problem(), poses);
  const auto turned = [&](const Eigen::Vector3d& axis) {
    for (size_t i = 0; i < poses.size(); ++i) {
      const SE3 T = SE3(ExpSO3(0.05 * axis), Eigen::Vector3d::Zero()) * moving.problem().poses[i].T_w_c;
      const int column = poses[i].column;
      poses[i] = AdjustedPose(T, column);
    }
    return chain.Loss();
  };
  EXPECT_LT(turned(Eigen::Vector3d::UnitZ()), 0.3);
  EXPECT_GT(turned(Eigen::Vector3d::UnitX()), 50.0);
}

/// Points that all poses observe with much noise: their positions are poorly known.
void AddPoorViews(BundleProblem& problem, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  problem.camera = {400.0, 320.0, 240.0, 0.12, 640, 480};
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d p_c(0.3 * (i % 6) - 0.8, 0.4 * (i / 6) - 0.8, 6.0 + 0.2 * (i % 4));
    problem.points.push_back({problem.poses.front().T_w_c * p_c, true});
  }
  for (size_t pose = 0; pose < problem.poses.size(); ++pose) {
    for (size_t point = 0; point < problem.points.size(); ++point) {
      const Eigen::Vector3d p_c = problem.poses[pose].T_w_c.Inverse() * problem.points[point].p_w;
      PointObservation observation;
      observation.pose = static_cast<int>(pose);
      observation.point = static_cast<int>(point);
      observation.uvd = problem.camera.ProjectStereo(p_c) +
                        Eigen::Vector3d(2.0 * normal(random), 2.0 * normal(random), normal(random));
      observation.sigma_px = 2.0;
      problem.point_observations.push_back(observation);
    }
  }
}

double MeanError(const BundleProblem& truth, const BundleResult& result) {
  double sum = 0.0;
  for (size_t i = 1; i < truth.poses.size(); ++i)
    sum += (result.T_w_c[i].translation() - truth.poses[i].T_w_c.translation()).norm();
  return sum / static_cast<double>(truth.poses.size() - 1);
}

TEST(InertialChain, BundleIsMoreAccurateWithIt) {
  double with = 0.0, without = 0.0;
  for (uint32_t seed = 1; seed <= 10; ++seed) {
    Moving moving(8);
    BundleProblem problem = moving.problem();
    AddPoorViews(problem, seed);
    const BundleResult sensed = AdjustBundle(problem, {});
    ASSERT_TRUE(sensed.ok) << sensed.reason;
    with += MeanError(moving.problem(), sensed);
    problem.inertial_motions.clear();
    without += MeanError(moving.problem(), AdjustBundle(problem, {}));
  }
  EXPECT_LT(with, 0.7 * without) << with / 10 << " and " << without / 10 << " m";
}

// The loss of a wrong motion grows linearly, so observations outweigh it.
TEST(InertialChain, WrongMotionDoesLittleHarm) {
  Moving moving(8);
  BundleProblem problem = moving.problem();
  AddPoorViews(problem, 1);
  const double right = MeanError(moving.problem(), AdjustBundle(problem, {}));
  // A motion from elsewhere on the path.
  problem.inertial_motions[3].sensed = problem.inertial_motions[6].sensed;
  EXPECT_LT(MeanError(moving.problem(), AdjustBundle(problem, {})), 2.0 * right);
}

TEST(InertialChain, PoseOutsideOfTheProblemIsNamed) {
  Moving moving(3);
  BundleProblem problem = moving.problem();
  AddPoorViews(problem, 1);
  problem.inertial_motions[1].b = 7;
  const BundleResult result = AdjustBundle(problem, {});
  EXPECT_FALSE(result.ok);
  EXPECT_EQ(result.reason, "an inertial motion is between poses 1 and 7 of 3");
}

}  // namespace
}  // namespace plslam
