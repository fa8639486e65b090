// SPDX-License-Identifier: BSD-3-Clause
#include "core/inertial/preintegration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/datasets/synthetic/inertial_sensor.h"
#include "core/datasets/synthetic/motion.h"
#include "core/datasets/synthetic/worlds.h"
#include "tests/unit/inertial/smooth_motion.h"

namespace plslam {
namespace {

using test::SmoothMotion;

constexpr int64_t kSecond_ns = 1'000'000'000;

Eigen::Vector3d RotationBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return SE3(a.conjugate() * b, Eigen::Vector3d::Zero()).Log().tail<3>();
}

ImuBias SomeBias() { return {{0.03, -0.02, 0.05}, {0.2, -0.1, 0.15}}; }

TEST(Preintegration, ExactIntegralsOfASmoothMotion) {
  const SmoothMotion motion;
  const std::vector<ImuSample> samples = motion.Samples(2000.0, 0.4, 2.0);
  const auto sum = Preintegrate(samples, kSecond_ns / 2 + 123'456, 3 * kSecond_ns / 2 + 7, {}, {});
  ASSERT_TRUE(sum);
  const double i = 0.500123456, j = 1.500000007, t = j - i;
  EXPECT_NEAR(sum->dt_s(), t, 1e-12);
  const Eigen::Vector3d g(0.0, 0.0, -SmoothMotion::kGravity);
  const Eigen::Matrix3d R_t = motion.Rotation(i).toRotationMatrix().transpose();
  EXPECT_LT(RotationBetween(motion.Rotation(i).conjugate() * motion.Rotation(j), sum->dR()).norm(), 1e-6);
  EXPECT_LT((sum->dv_m_s() - R_t * (motion.Velocity(j) - motion.Velocity(i) - g * t)).norm(), 1e-6);
  EXPECT_LT((sum->dp_m() - R_t * (motion.Position(j) - motion.Position(i) - motion.Velocity(i) * t - 0.5 * g * t * t))
                .norm(),
            1e-6);
}

TEST(Preintegration, PosesOfAWorldFromItsSamples) {
  const synthetic::WorldKind& room = synthetic::FindWorldKind("room");
  const synthetic::WalkMotion walk(room.walk(), room.walk().speed, 20.0, 1);
  const auto samples = synthetic::SampleMotion({&walk, 20.0, 3.0, Eigen::Vector3d::UnitZ()}, 1000.0,
                                               synthetic::SensorClasses().back(), 1);
  const auto pose = [&](double t_s) { return walk.At(20.0 * t_s) * synthetic::MountedSensor(); };
  const auto sum = Preintegrate(samples, kSecond_ns, 2 * kSecond_ns, {}, {});
  ASSERT_TRUE(sum);
  const SE3 from = pose(1.0), to = pose(2.0);
  EXPECT_LT(RotationBetween(from.rotation().conjugate() * to.rotation(), sum->dR()).norm(), 1e-6);
  // The path of a world has steps of velocity of some 0.1 mm/s, of which a derivative at one time is a part.
  constexpr double kStep_s = 1e-3;
  const Eigen::Vector3d v_i =
      (pose(1.0 + kStep_s).translation() - pose(1.0 - kStep_s).translation()) / (2.0 * kStep_s);
  const Eigen::Vector3d expected = from.rotation().conjugate() * (to.translation() - from.translation() - v_i +
                                                                  Eigen::Vector3d(0.0, 0.0, 0.5 * 9.81));
  EXPECT_LT((sum->dp_m() - expected).norm(), 1e-3);
}

TEST(Preintegration, BiasJacobiansAreTheDerivatives) {
  const std::vector<ImuSample> samples = SmoothMotion().Samples(200.0, 0.0, 1.0);
  const auto integrate = [&](const ImuBias& bias) { return *Preintegrate(samples, 0, kSecond_ns / 2, {}, bias); };
  const ImuBias bias = SomeBias();
  const Preintegration at = integrate(bias);
  constexpr double kStep = 1e-5;
  for (int axis = 0; axis < 3; ++axis) {
    ImuBias rate = bias, force = bias;
    rate.rate_rad_s[axis] += kStep;
    force.force_m_s2[axis] += kStep;
    const Preintegration by_rate = integrate(rate), by_force = integrate(force);
    const Preintegration::Jacobians& J = at.jacobians();
    EXPECT_LT((RotationBetween(at.dR(), by_rate.dR()) / kStep - J.R_rate.col(axis)).norm(), 1e-4);
    EXPECT_LT(((by_rate.dv_m_s() - at.dv_m_s()) / kStep - J.v_rate.col(axis)).norm(), 1e-4);
    EXPECT_LT(((by_rate.dp_m() - at.dp_m()) / kStep - J.p_rate.col(axis)).norm(), 1e-4);
    EXPECT_LT(((by_force.dv_m_s() - at.dv_m_s()) / kStep - J.v_force.col(axis)).norm(), 1e-6);
    EXPECT_LT(((by_force.dp_m() - at.dp_m()) / kStep - J.p_force.col(axis)).norm(), 1e-6);
    EXPECT_LT(RotationBetween(at.RotationWith(rate), by_rate.dR()).norm(), 1e-9);
    EXPECT_LT((at.VelocityWith(rate) - by_rate.dv_m_s()).norm(), 1e-9);
    EXPECT_LT((at.PositionWith(force) - by_force.dp_m()).norm(), 1e-9);
  }
}

TEST(Preintegration, CovarianceIsThatOfRandomDraws) {
  const ImuNoise noise{0.002, 1e-5, 0.03, 1e-4};
  const SmoothMotion motion;
  constexpr double kRate_hz = 200.0;
  constexpr int kDraws = 3000, kSteps = 60;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto draw = [&](double density) {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = density * std::sqrt(kRate_hz) * normal(random);
    return v;
  };
  const auto integrate = [&](double scale) {
    Preintegration sum(noise, {});
    for (int i = 0; i < kSteps; ++i) {
      const double t = (i + 0.5) / kRate_hz;
      sum.Append(motion.Rate(t) + scale * draw(noise.gyroscope_rad_s_sqrt_hz),
                 motion.Force(t) + scale * draw(noise.accelerometer_m_s2_sqrt_hz), 1.0 / kRate_hz);
    }
    return sum;
  };
  const Preintegration mean = integrate(0.0);
  Preintegration::Matrix9d drawn = Preintegration::Matrix9d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Preintegration sum = integrate(1.0);
    Eigen::Matrix<double, 9, 1> error;
    error << RotationBetween(mean.dR(), sum.dR()), sum.dv_m_s() - mean.dv_m_s(), sum.dp_m() - mean.dp_m();
    drawn += error * error.transpose() / kDraws;
  }
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(drawn(i, i) / mean.covariance()(i, i), 1.0, 0.1) << i;
}

/// Squared and normalised error of what is integrated from these samples, with 9 degrees of freedom.
double NormalisedError(const std::vector<ImuSample>& samples, const Preintegration& truth, int64_t from_ns,
                       int64_t to_ns, const ImuNoise& noise) {
  const Preintegration sum = Preintegrate(samples, from_ns, to_ns, noise, {}).value();
  Eigen::Matrix<double, 9, 1> error;
  error << RotationBetween(truth.dR(), sum.dR()), sum.dv_m_s() - truth.dv_m_s(), sum.dp_m() - truth.dp_m();
  return error.cwiseAbs2().cwiseQuotient(sum.covariance().diagonal()).sum();
}

// A sensor without noise to speak of, so that the error is that of what was not sensed. Its motion changes quickly.
TEST(Preintegration, CovarianceContainsWhatWasNotSensed) {
  const ImuNoise noise{1e-5, 1e-6, 1e-4, 1e-5};
  std::vector<ImuSample> all;
  for (int i = 0; i <= 400; ++i) {
    const double t = i / 200.0;
    all.push_back({i * 5'000'000,
                   {0.8 * std::sin(9.0 * t), 0.6 * std::cos(11.0 * t), 0.5 * std::sin(7.0 * t + 1.0)},
                   {2.0 * std::cos(8.0 * t), 3.0 * std::sin(10.0 * t), 9.81 + 2.0 * std::sin(9.0 * t)}});
  }
  double held = 0.0, gap = 0.0;
  constexpr int kDraws = 30;
  for (int i = 0; i < kDraws; ++i) {
    const int64_t from_ns = i * 50'000'000, to_ns = from_ns + 200'000'000;
    const Preintegration truth = Preintegrate(all, from_ns, to_ns, noise, {}).value();
    EXPECT_LT(truth.covariance()(0, 0), 1e-10) << "nothing is added where all samples are there";
    std::vector<ImuSample> cut = all;
    std::erase_if(cut, [&](const ImuSample& s) { return s.t_ns > to_ns - 20'000'000 && s.t_ns < to_ns + 1; });
    std::vector<ImuSample> until(
        cut.begin(), std::find_if(cut.begin(), cut.end(), [&](const ImuSample& s) { return s.t_ns > to_ns; }));
    held += NormalisedError(until, truth, from_ns, to_ns, noise) / kDraws;
    std::vector<ImuSample> without = all;
    std::erase_if(
        without, [&](const ImuSample& s) { return s.t_ns > from_ns + 50'000'000 && s.t_ns < from_ns + 150'000'000; });
    gap += NormalisedError(without, truth, from_ns, to_ns, noise) / kDraws;
  }
  EXPECT_LT(held, 27.0) << "three times the expected 9";
  EXPECT_LT(gap, 27.0);
  EXPECT_GT(held, 0.5);
  EXPECT_GT(gap, 0.5);
}

TEST(Preintegration, MissingSamplesAreReported) {
  std::vector<ImuSample> samples = SmoothMotion().Samples(100.0, 0.0, 1.0);
  const auto covers = [&](int64_t from_ms, int64_t to_ms) {
    return Preintegrate(samples, from_ms * 1'000'000, to_ms * 1'000'000, {}, {}).has_value();
  };
  EXPECT_TRUE(covers(0, 1000));
  EXPECT_TRUE(covers(-15, 1015)) << "the outermost samples hold";
  EXPECT_FALSE(covers(-30, 500));
  EXPECT_FALSE(covers(500, 1030));
  EXPECT_FALSE(covers(500, 500));
  samples.erase(samples.begin() + 40, samples.begin() + 45);
  EXPECT_TRUE(covers(300, 600)) << "a few are missing here and there";
  samples.erase(samples.begin() + 40, samples.begin() + 60);
  EXPECT_FALSE(covers(300, 800));
  EXPECT_TRUE(covers(0, 300)) << "the gap is elsewhere";
  samples.clear();
  EXPECT_FALSE(covers(0, 1));
}

}  // namespace
}  // namespace plslam
