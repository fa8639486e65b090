// SPDX-License-Identifier: BSD-3-Clause
#include "core/inertial/sample_checks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace plslam {
namespace {

constexpr double kRate_hz = 200.0;

/// A sensor in motion whose rates and forces have white noise.
class Sensor {
 public:
  /// Adds samples; rates end at `bound`, and forces contain a vibration of this amplitude.
  void Run(double time_s, double noise, double bound = 1e9, double vibration_m_s2 = 0.0) {
    for (const double end_s = t_s_ + time_s; t_s_ < end_s; t_s_ += 1.0 / kRate_hz) {
      ImuSample sample;
      sample.t_ns = std::llround(1e9 * t_s_);
      for (int i = 0; i < 3; ++i) {
        sample.rate_rad_s[i] = std::sin(2.0 * t_s_ + i) + noise * normal_(random_);
        sample.force_m_s2[i] = 10.0 * noise * normal_(random_);
      }
      sample.rate_rad_s = sample.rate_rad_s.cwiseMin(bound).eval();
      sample.force_m_s2.z() += 9.81;
      sample.force_m_s2.x() += vibration_m_s2 * std::sin(2.0 * M_PI * 8.0 * t_s_);
      checks.Add(sample);
    }
  }

  SampleChecks checks;

 private:
  double t_s_ = 0.0;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
};

TEST(SampleChecks, NewNoiseIsFoundAfterALongTime) {
  Sensor sensor;
  sensor.Run(600.0, 0.001);
  const double before = sensor.checks.RateNoise();
  sensor.Run(2.0, 0.1);
  EXPECT_GT(sensor.checks.RateNoise(), 20.0 * before);
  sensor.Run(120.0, 0.001);
  EXPECT_LT(sensor.checks.RateNoise(), 2.0 * before) << "it has ended";
}

TEST(SampleChecks, ShareOfSaturatedSamplesIsThatOfTheLastOnes) {
  Sensor sensor;
  sensor.Run(20.0, 0.001, 0.9);
  const SampleChecks::Saturation present = sensor.checks.MostSaturated();
  EXPECT_GT(present.n_samples, 100);
  EXPECT_GT(present.share, 0.02);
  EXPECT_GE(sensor.checks.n_saturated(), present.n_samples);
  sensor.Run(60.0, 0.001, 0.8);
  const SampleChecks::Saturation past = sensor.checks.MostSaturated();
  EXPECT_EQ(past.n_samples, present.n_samples);
  EXPECT_LT(past.share, 0.002) << "it is not that of a session";
}

TEST(SampleChecks, ForcesOfAVibrationAverageOut) {
  Sensor sensor;
  sensor.Run(10.0, 0.001, 1e9, 20.0);
  EXPECT_NEAR(sensor.checks.Force_m_s2(), 9.81, 0.8);
}

TEST(SampleChecks, ForceIsThatOfTheLastSeconds) {
  Sensor sensor;
  sensor.Run(200.0, 0.001);
  const double before_m_s2 = sensor.checks.Force_m_s2();
  EXPECT_NEAR(before_m_s2, 9.81, 0.01);
  SampleChecks checks = sensor.checks;
  for (int i = 0; i < 40 * kRate_hz; ++i) {
    checks.Add({std::llround(1e9 * (200.1 + i / kRate_hz)), {0.0, 0.0, 0.1}, {0.0, 0.0, 1.0}});
  }
  EXPECT_LT(checks.Force_m_s2(), 1.5);
}

}  // namespace
}  // namespace plslam
