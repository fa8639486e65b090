// SPDX-License-Identifier: BSD-3-Clause
// The true motions of synthetic worlds, with the noise of measured ones, and sensors with faults.
#include "core/inertial/sensor_diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/datasets/synthetic/exact_math.h"
#include "core/datasets/synthetic/simulator.h"

namespace plslam {
namespace {

using synthetic::ParseOptions;
using synthetic::Simulator;
using testing::HasSubstr;

constexpr double kTurn_rad = 2e-4;
constexpr double kStep_m = 1e-3;

/// Findings about the sensor of a world, and the comparison of turns.
struct Diagnosed {
  std::string harmful;
  std::string harmless;
  TurnFit fit;
  int n_changes = 0;  ///< between a sensor that is used and one that is not
};

Diagnosed Diagnose(const std::string& world, int frames = 200) {
  const Simulator simulator(ParseOptions(world + "&size=32x32&frames=" + std::to_string(frames)));
  const ImuCalibration& stated = *simulator.rig().imu;
  const SE3 T_imu_c = stated.T_b_imu.Inverse();
  SensorDiagnosis diagnosis(stated, T_imu_c);
  synthetic::Random random(7);
  const auto noise = [&random](double sigma) {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = sigma * std::sqrt(12.0) * (random.Uniform() - 0.5);
    return v;
  };
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kStep_m), Eigen::Vector3d::Constant(kTurn_rad);
  Diagnosed result;
  for (int i = 1; i < simulator.size(); ++i) {
    const bool was_harmful = diagnosis.IsHarmful();
    diagnosis.Add(simulator.imu_samples(), simulator.t_ns(i));
    Vector6d error;
    error.head<3>() = noise(kStep_m);
    error.tail<3>() = noise(kTurn_rad);
    const SE3 T_prev_c = simulator.T_w_c(i - 1).Inverse() * simulator.T_w_c(i) * SE3::Exp(error);
    diagnosis.Add(simulator.t_ns(i - 1), simulator.t_ns(i), T_prev_c, sigma.cwiseAbs2().asDiagonal());
    result.n_changes += diagnosis.IsHarmful() != was_harmful ? 1 : 0;
  }
  result.fit = diagnosis.fit();
  for (const SensorFinding& finding : diagnosis.findings()) {
    (finding.is_harmful ? result.harmful : result.harmless) += finding.text + "|";
  }
  return result;
}

const std::vector<std::string>& Worlds() {
  static const std::vector<std::string> worlds = {"room?imu=200", "street?imu=200&speed=10", "corridor?imu=200"};
  return worlds;
}

void ExpectHarmful(const std::string& fault, const std::string& sentence) {
  for (const std::string& world : Worlds()) {
    EXPECT_THAT(Diagnose(world + "&imu_fault=" + fault).harmful, HasSubstr(sentence)) << world << " " << fault;
  }
}

TEST(SensorDiagnosis, HealthySensorsHaveNoFinding) {
  for (const std::string world :
       {"room?imu=200", "street?imu=100", "corridor?imu=400&imu_class=icm20948", "whitewall?imu=200&imu_class=bmi055",
        "room?imu=200&turning=40", "room?imu=200&standing=1", "room?imu=200&imu_class=exact",
        "room?imu=200&imu_class=exact&standing=1", "room?imu=200&imu_fault=duplicated"}) {
    const Diagnosed diagnosed = Diagnose(world);
    EXPECT_EQ(diagnosed.harmful + diagnosed.harmless, "") << world;
  }
}

TEST(SensorDiagnosis, UnitsAreNamedWithTheRatio) {
  ExpectHarmful("g", "instead of 9.8: g instead of m/s^2?");
  ExpectHarmful("degrees", "times as fast as the images: degrees instead of rad/s?");
  EXPECT_NEAR(Diagnose("room?imu=200&imu_fault=degrees").fit.scale, 57.3, 0.5);
}

TEST(SensorDiagnosis, MountingIsNamedWithTheRightOne) {
  ExpectHarmful("exchanged", "about (y, x, z) where the images turn about (x, y, z): axes exchanged or inverted");
  ExpectHarmful("exchanged&imu_fault_size=1", "about (x, z, y)");
  ExpectHarmful("inverted", "about (x, y, -z)");
  ExpectHarmful("turned", "about (x, -z, y) where the images turn about (x, y, z): the rotation of T_b_imu would be");
  ExpectHarmful("turned&imu_fault_size=180", "about (x, -y, -z)");
  ExpectHarmful("turned&imu_fault_size=30", "it is turned by 30 degrees from the stated mounting");
  ExpectHarmful("extrinsics", "is T_b_imu the wrong way round? Its rotation would be [0, -1, 0; 0, 0, -1; 1, 0, 0]");
}

TEST(SensorDiagnosis, OneTurnDoesNotShowWhichAxesAreWrong) {
  const Diagnosed diagnosed = Diagnose("room?imu=200&turning=40&imu_fault=inverted");
  EXPECT_GT(diagnosed.fit.n_rivals, 0);
  EXPECT_THAT(diagnosed.harmful, HasSubstr("is the rotation of T_b_imu right?"));
}

TEST(SensorDiagnosis, TimeOffsetIsEstimatedWithItsSigma) {
  for (const std::string& world : Worlds()) {
    for (const double ms : {20.0, -20.0, 100.0, 250.0}) {
      const Diagnosed diagnosed = Diagnose(world + "&imu_fault=offset&imu_fault_size=" + std::to_string(ms));
      const TurnFit& fit = diagnosed.fit;
      EXPECT_LT(fit.delay_sigma_s, 0.003) << world;
      EXPECT_NEAR(1e3 * fit.delay_s, ms, 0.5 + 3e3 * fit.delay_sigma_s) << world;
      EXPECT_THAT(diagnosed.harmful, HasSubstr(ms > 0.0 ? "late: time_offset_s: -" : "early: time_offset_s: 0"))
          << world;
    }
  }
}

TEST(SensorDiagnosis, FaultySamplesAreNamed) {
  ExpectHarmful("stuck", "its samples have been the same for 5.8 s while the images move: it is stuck");
  EXPECT_THAT(Diagnose("room?imu=200&turning=40&imu_fault=noisy").harmful, HasSubstr("105 times the stated one"));
  ExpectHarmful("saturated", "about z: the range of the gyroscope is too small");
  ExpectHarmful("noisy", "times the stated one: gyroscope_noise_density: 0.018");
  for (const std::string& world : Worlds()) {
    EXPECT_THAT(Diagnose(world + "&imu_fault=gaps").harmless, HasSubstr("3 gaps, the longest of 0.30 s")) << world;
    EXPECT_THAT(Diagnose(world + "&imu_fault=rate").harmless,
                HasSubstr("200 samples a second instead of the stated 400"))
        << world;
    EXPECT_THAT(Diagnose(world + "&imu_fault=rate&imu_fault_size=2").harmless, HasSubstr("instead of the stated 100"))
        << world;
  }
}

// 8 ms is the bound.
TEST(SensorDiagnosis, DelayNearTheBoundDoesNotComeAndGo) {
  for (const double ms : {7.8, 8.3}) {
    for (const std::string& world : Worlds()) {
      const Diagnosed diagnosed = Diagnose(world + "&imu_fault=offset&imu_fault_size=" + std::to_string(ms), 400);
      EXPECT_LE(diagnosed.n_changes, 2) << world << ", " << ms << " ms";
    }
  }
}

TEST(SensorDiagnosis, FaultsAtTwoFramesASecondAreNamed) {
  const std::string world = "room?imu=200&rate=2";
  EXPECT_EQ(Diagnose(world, 60).harmful, "");
  EXPECT_THAT(Diagnose(world + "&imu_fault=degrees", 60).harmful, HasSubstr("degrees instead of rad/s?"));
  EXPECT_THAT(Diagnose(world + "&imu_fault=inverted", 60).harmful, HasSubstr("about (x, y, -z)"));
  EXPECT_THAT(Diagnose(world + "&imu_fault=offset&imu_fault_size=100", 60).harmful,
              HasSubstr("late: time_offset_s: -"));
}

// A sensor on an engine: 10 m/s^2 rms at 8 Hz, so that the rms of the force is 14 m/s^2.
TEST(SensorDiagnosis, VibrationIsNoOtherUnit) {
  const Simulator simulator(ParseOptions("room?imu=200&size=32x32&frames=100"));
  const ImuCalibration& stated = *simulator.rig().imu;
  std::vector<ImuSample> samples = simulator.imu_samples();
  for (ImuSample& sample : samples) {
    sample.force_m_s2.z() += 15.0 * std::sin(16.0 * M_PI * 1e-9 * static_cast<double>(sample.t_ns));
  }
  SensorDiagnosis diagnosis(stated, stated.T_b_imu.Inverse());
  for (int i = 1; i < simulator.size(); ++i) {
    diagnosis.Add(samples, simulator.t_ns(i));
    diagnosis.Add(simulator.t_ns(i - 1), simulator.t_ns(i), simulator.T_w_c(i - 1).Inverse() * simulator.T_w_c(i),
                  1e-8 * Matrix6d::Identity());
    for (const SensorFinding& finding : diagnosis.findings()) {
      EXPECT_NE(finding.fault, SensorFinding::Fault::kForceUnit) << finding.text;
    }
  }
}

// Kerbs and landings: a few saturated samples are no reason to do without the sensor from then on.
TEST(SensorDiagnosis, FewSaturatedSamplesDoNoHarm) {
  const Simulator simulator(ParseOptions("room?imu=200&size=32x32&frames=400"));
  const ImuCalibration& stated = *simulator.rig().imu;
  std::vector<ImuSample> samples = simulator.imu_samples();
  for (size_t i = 3000; i < 3025; ++i) samples[i].force_m_s2.z() = 39.0;
  SensorDiagnosis diagnosis(stated, stated.T_b_imu.Inverse());
  int n_left_out = 0;
  for (int i = 1; i < simulator.size(); ++i) {
    n_left_out += diagnosis.Add(samples, simulator.t_ns(i)) ? 0 : 1;
    diagnosis.Add(simulator.t_ns(i - 1), simulator.t_ns(i), simulator.T_w_c(i - 1).Inverse() * simulator.T_w_c(i),
                  1e-8 * Matrix6d::Identity());
    EXPECT_FALSE(diagnosis.IsHarmful()) << "frame " << i << ": " << diagnosis.findings().front().text;
  }
  EXPECT_GE(n_left_out, 1);
  ASSERT_EQ(diagnosis.findings().size(), 1U) << "it is said";
  EXPECT_THAT(diagnosis.findings().front().text, HasSubstr("the range of the accelerometer is too small"));
}

TEST(SensorDiagnosis, HostileSamplesDoNoHarm) {
  SensorDiagnosis diagnosis(ImuCalibration{}, SE3{});
  constexpr int64_t kMost = std::numeric_limits<int64_t>::max(), kLeast = std::numeric_limits<int64_t>::min();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d huge = Eigen::Vector3d::Constant(1e300), none = Eigen::Vector3d::Constant(nan);
  const std::vector<ImuSample> samples = {
      {kLeast, huge, huge}, {0, none, none}, {1, huge, none}, {kMost, none, huge}};
  for (int64_t i = 0; i < 200; ++i) {
    diagnosis.Add(samples, kMost);
    diagnosis.Add(i * 50'000'000, (i + 1) * 50'000'000, SE3(), Matrix6d::Identity() * 1e-8);
    diagnosis.Add(kLeast, kMost, SE3(), Matrix6d::Zero());
  }
  EXPECT_EQ(diagnosis.fit().pairs, 0.0);
}

}  // namespace
}  // namespace plslam
