// SPDX-License-Identifier: BSD-3-Clause
#include "core/inertial/inertial_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/unit/inertial/smooth_motion.h"

namespace plslam {
namespace {

using test::SmoothMotion;

constexpr double kFrame_s = 0.05;
constexpr double kDegree = 3.14159265358979323846 / 180.0;

Matrix6d PoseCovariance() {
  Vector6d sigma;
  sigma << 0.002, 0.002, 0.002, 5e-4, 5e-4, 5e-4;
  return sigma.cwiseAbs2().asDiagonal();
}

/// Filters noisy poses of a motion, and samples with this bias, over the frames of `seconds`. Odom is the pose at the
/// start, which is not level.
class FilteredMotion {
 public:
  FilteredMotion(const SmoothMotion& motion, const ImuBias& bias)
      : motion_(motion), samples_(motion.Samples(200.0, 0.0, 20.0)) {
    for (ImuSample& sample : samples_) {
      sample.rate_rad_s += bias.rate_rad_s;
      sample.force_m_s2 += bias.force_m_s2;
    }
    filter_.Begin(Measured(), PoseCovariance(), samples_.front().force_m_s2, false);
  }

  void Follow(double seconds) {
    for (const double end_s = t_s_ + seconds; t_s_ < end_s - 1e-6;) {
      Propagate();
      filter_.Update(Measured(), PoseCovariance());
      filter_.MeasureFromHere();
    }
  }
  void Propagate() {
    const auto ns = [](double s) { return std::llround(s * 1e9); };
    filter_.Propagate(*Preintegrate(samples_, ns(t_s_), ns(t_s_ + kFrame_s), ImuNoise(), filter_.state().bias));
    t_s_ += kFrame_s;
  }
  SE3 Truth() const { return motion_.Pose(0.0).Inverse() * motion_.Pose(t_s_); }
  Eigen::Vector3d Velocity() const { return motion_.Rotation(0.0).conjugate() * motion_.Velocity(t_s_); }
  Eigen::Vector3d Gravity() const {
    return motion_.Rotation(0.0).conjugate() * Eigen::Vector3d(0.0, 0.0, -SmoothMotion::kGravity);
  }
  const InertialFilter& filter() const { return filter_; }

 private:
  SE3 Measured() {
    Vector6d x;
    for (int i = 0; i < 6; ++i) x[i] = std::sqrt(PoseCovariance()(i, i)) * normal_(random_);
    return Truth() * SE3::Exp(x);
  }

  SmoothMotion motion_;
  std::vector<ImuSample> samples_;
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
  double t_s_ = 0.0;
  InertialFilter filter_{ImuNoise()};
};

double Angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

TEST(InertialFilter, FindsVelocityGravityAndGyroBiasInASecond) {
  const ImuBias bias{{0.02, -0.08, 0.05}, {0.05, -0.1, 0.08}};
  for (const double speed_m_s : {0.0, 10.0}) {
    FilteredMotion run(SmoothMotion{speed_m_s}, bias);
    run.Follow(1.0);
    const InertialState& state = run.filter().state();
    EXPECT_LT((state.velocity_m_s - run.Velocity()).norm(), 0.03) << speed_m_s;
    EXPECT_LT((state.bias.rate_rad_s - bias.rate_rad_s).norm(), 0.005) << speed_m_s;
    EXPECT_LT(Angle(state.gravity_m_s2, run.Gravity()), 3.0 * kDegree) << speed_m_s;
    run.Follow(9.0);
    EXPECT_LT((state.bias.rate_rad_s - bias.rate_rad_s).norm(), 0.002) << speed_m_s;
    EXPECT_LT((state.bias.force_m_s2 - bias.force_m_s2).norm(), 0.05) << speed_m_s;
    EXPECT_LT(Angle(state.gravity_m_s2, run.Gravity()), 0.3 * kDegree) << speed_m_s;
  }
}

TEST(InertialFilter, VerticalHasAnHonestSigma) {
  EXPECT_FALSE(FilteredMotion(SmoothMotion{1.0}, {}).filter().Up()) << "the first sample contains the acceleration";
  for (const double speed_m_s : {0.0, 10.0}) {
    FilteredMotion run(SmoothMotion{speed_m_s}, {{0.02, -0.08, 0.05}, {0.05, -0.1, 0.08}});
    run.Follow(1.0);
    double sigma_rad = 1.0;
    for (int i = 0; i < 8; ++i) {
      const auto up = run.filter().Up();
      ASSERT_TRUE(up) << i;
      const Eigen::Vector3d truth = -(run.Truth().rotation().conjugate() * run.Gravity().normalized());
      EXPECT_LT(Angle(up->direction, truth), 3.5 * up->sigma_rad) << speed_m_s << " m/s, second " << i;
      EXPECT_LT(up->sigma_rad, sigma_rad * 1.05);
      sigma_rad = up->sigma_rad;
      run.Follow(1.0);
    }
    EXPECT_LT(sigma_rad, 0.3 * kDegree) << speed_m_s;
  }
}

TEST(InertialFilter, CarriesThePoseWithAnHonestCovariance) {
  FilteredMotion run(SmoothMotion{1.0}, {{0.02, -0.08, 0.05}, {0.05, -0.1, 0.08}});
  run.Follow(2.0);
  const SE3 before = run.filter().state().T_odom_imu, truth_before = run.Truth();
  double sigma_m = 0.0;
  for (int i = 0; i < 20; ++i) {
    run.Propagate();
    const SE3 truth = truth_before.Inverse() * run.Truth();
    const SE3 motion = before.Inverse() * run.filter().state().T_odom_imu;
    EXPECT_LT((motion.Inverse() * run.filter().Motion()).Log().norm(), 1e-9);
    const Vector6d error = (motion.Inverse() * truth).Log();
    EXPECT_LT(error.head<3>().norm(), 0.03) << i;
    const double chi2 = error.dot(run.filter().MotionCovariance().ldlt().solve(error));
    EXPECT_LT(chi2, 25.0) << i;
    const double next_m = std::sqrt(run.filter().MotionCovariance()(0, 0));
    EXPECT_GT(next_m, sigma_m) << i;
    sigma_m = next_m;
  }
  EXPECT_LT(sigma_m, 0.1);
}

TEST(InertialFilter, InnovationOfAWrongPoseIsLarge) {
  FilteredMotion run(SmoothMotion{1.0}, {});
  run.Follow(2.0);
  run.Propagate();
  EXPECT_LT(run.filter().AgreementWith(run.Truth(), PoseCovariance()).innovation, 25.0);
  const SE3 wrong = run.Truth() * SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1, 0.0, 0.0));
  EXPECT_GT(run.filter().AgreementWith(wrong, PoseCovariance()).innovation, 100.0);
}

// Two motions are compared by how surprising their poses are: an inaccurate pose decides nothing.
TEST(InertialFilter, SurpriseIsThatOfAccuratePoses) {
  FilteredMotion run(SmoothMotion{1.0}, {});
  run.Follow(2.0);
  run.Propagate();
  const SE3 wrong = run.Truth() * SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1, 0.0, 0.0));
  const double right_surprise = run.filter().AgreementWith(run.Truth(), PoseCovariance()).surprise;
  EXPECT_GT(run.filter().AgreementWith(wrong, PoseCovariance()).surprise, right_surprise + 50.0);
  const Matrix6d vague = 1e4 * Matrix6d::Identity();
  EXPECT_NEAR(run.filter().AgreementWith(wrong, vague).surprise, 0.0, 0.1);
}

TEST(InertialFilter, StandStillEndsVelocityOnly) {
  FilteredMotion run(SmoothMotion{1.0}, {});
  run.Follow(2.0);
  InertialFilter filter = run.filter();
  const SE3 before = filter.state().T_odom_imu;
  ASSERT_GT(filter.state().velocity_m_s.norm(), 0.1);
  filter.StandStill(1e-4);
  EXPECT_LT(filter.state().velocity_m_s.norm(), 0.01);
  EXPECT_LT(filter.covariance().diagonal().segment<3>(6).maxCoeff(), 1e-7);
  EXPECT_LT((before.Inverse() * filter.state().T_odom_imu).translation().norm(), 0.2);
}

}  // namespace
}  // namespace plslam
