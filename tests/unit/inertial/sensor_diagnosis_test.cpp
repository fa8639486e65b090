// SPDX-License-Identifier: BSD-3-Clause
// The true motions of synthetic worlds, with the noise of measured ones, and sensors with faults.
#include "core/inertial/sensor_diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/datasets/synthetic/exact_math.h"
#include "core/datasets/synthetic/simulator.h"
#include "core/io/files/archive.h"

namespace plslam {
namespace {

using synthetic::ParseOptions;
using synthetic::Simulator;
using testing::HasSubstr;

constexpr double kTurn_rad = 2e-4;
constexpr double kStep_m = 1e-3;

/// The sensor of a world after its frames, restored from its state every so many frames.
struct Diagnosed {
  std::string harmful;
  std::string harmless;
  TurnFit fit;
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
  for (int i = 1; i < simulator.size(); ++i) {
    diagnosis.Add(simulator.imu_samples(), simulator.t_ns(i));
    Vector6d error;
    error.head<3>() = noise(kStep_m);
    error.tail<3>() = noise(kTurn_rad);
    const SE3 T_prev_c = simulator.T_w_c(i - 1).Inverse() * simulator.T_w_c(i) * SE3::Exp(error);
    diagnosis.Add(simulator.t_ns(i - 1), simulator.t_ns(i), T_prev_c, sigma.cwiseAbs2().asDiagonal());
  }
  Diagnosed result;
  result.fit = diagnosis.fit();
  for (const SensorFinding& finding : diagnosis.findings()) {
    (finding.is_harmful ? result.harmful : result.harmless) += finding.text + "|";
  }
  return result;
}

TEST(SensorDiagnosis, Explore) {
  for (const std::string world : {"room?imu=200", "street?imu=200&speed=10", "whitewall?imu=200", "corridor?imu=200",
                                  "room?imu=200&turning=40", "room?imu=200&standing=1"}) {
    for (const std::string fault : {"",
                                    "&imu_fault=g",
                                    "&imu_fault=degrees",
                                    "&imu_fault=exchanged",
                                    "&imu_fault=exchanged&imu_fault_size=1",
                                    "&imu_fault=inverted",
                                    "&imu_fault=inverted&imu_fault_size=0",
                                    "&imu_fault=turned",
                                    "&imu_fault=turned&imu_fault_size=180",
                                    "&imu_fault=turned&imu_fault_size=30",
                                    "&imu_fault=extrinsics",
                                    "&imu_fault=offset",
                                    "&imu_fault=offset&imu_fault_size=-20",
                                    "&imu_fault=offset&imu_fault_size=100",
                                    "&imu_fault=offset&imu_fault_size=250",
                                    "&imu_fault=gaps",
                                    "&imu_fault=saturated",
                                    "&imu_fault=stuck",
                                    "&imu_fault=noisy",
                                    "&imu_fault=rate",
                                    "&imu_fault=rate&imu_fault_size=2",
                                    "&imu_fault=drifting",
                                    "&imu_fault=duplicated",
                                    "&imu_fault=reordered"}) {
      const Diagnosed d = Diagnose(world + fault);
      std::printf("%-26s %-38s ev %9.0f axes %2d rivals %2d scale %.4f delay %6.1f +- %.1f res %.2g | %s ## %s\n",
                  world.c_str(), fault.c_str(), d.fit.evidence, static_cast<int>(d.fit.axes), d.fit.n_rivals,
                  d.fit.scale, 1e3 * d.fit.delay_s, 1e3 * d.fit.delay_sigma_s, d.fit.residual_rad_sqrt_s,
                  d.harmful.c_str(), d.harmless.c_str());
    }
  }
}

}  // namespace
}  // namespace plslam
