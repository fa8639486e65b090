// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/sensor_faults.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/datasets/synthetic/exact_math.h"
#include "core/datasets/synthetic/inertial_sensor.h"

namespace plslam::synthetic {
namespace {

using ImuSamples = std::vector<ImuSample>;

// Time after the first sample at which a fault that a sensor develops begins, and the period of gaps.
constexpr double kBegins_s = 4.0;
constexpr double kGapPeriod_s = 3.0;
// Every so many samples one is sent twice, or after its successor.
constexpr size_t kEvery = 10;

double SecondsAfterFirst(const ImuSamples& samples, const ImuSample& sample) {
  return 1e-9 * static_cast<double>(sample.t_ns - samples.front().t_ns);
}

void InG(double, uint64_t, ImuSamples& samples, ImuCalibration&) {
  for (ImuSample& sample : samples) sample.force_m_s2 /= kGravity_m_s2;
}

void InDegrees(double, uint64_t, ImuSamples& samples, ImuCalibration&) {
  for (ImuSample& sample : samples) sample.rate_rad_s *= 180.0 / kPi;
}

/// The axes x and y, or as many steps further on.
void Exchanged(double first, uint64_t, ImuSamples& samples, ImuCalibration&) {
  const int a = static_cast<int>(first), b = (a + 1) % 3;
  for (ImuSample& sample : samples) {
    std::swap(sample.rate_rad_s[a], sample.rate_rad_s[b]);
    std::swap(sample.force_m_s2[a], sample.force_m_s2[b]);
  }
}

void Inverted(double axis, uint64_t, ImuSamples& samples, ImuCalibration&) {
  const int a = static_cast<int>(axis);
  for (ImuSample& sample : samples) {
    sample.rate_rad_s[a] *= -1.0;
    sample.force_m_s2[a] *= -1.0;
  }
}

/// The sensor is mounted turned about its axis x, which points forward.
void Turned(double deg, uint64_t, ImuSamples& samples, ImuCalibration&) {
  const double half_rad = 0.5 * deg * kPi / 180.0;
  const Eigen::Quaterniond q(Cos(half_rad), Sin(half_rad), 0.0, 0.0);
  for (ImuSample& sample : samples) {
    sample.rate_rad_s = (q * sample.rate_rad_s).eval();
    sample.force_m_s2 = (q * sample.force_m_s2).eval();
  }
}

void InverseExtrinsics(double, uint64_t, ImuSamples&, ImuCalibration& stated) {
  stated.T_b_imu = stated.T_b_imu.Inverse();
}

void Offset(double ms, uint64_t, ImuSamples& samples, ImuCalibration&) {
  for (ImuSample& sample : samples) sample.t_ns += static_cast<int64_t>(std::floor(1e6 * ms + 0.5));
}

void Gaps(double s, uint64_t, ImuSamples& samples, ImuCalibration&) {
  const int64_t first_ns = samples.front().t_ns;
  std::erase_if(samples, [&](const ImuSample& sample) {
    const double t_s = 1e-9 * static_cast<double>(sample.t_ns - first_ns);
    const double after_s = t_s - kGapPeriod_s * std::floor(t_s / kGapPeriod_s);
    return t_s >= kGapPeriod_s && after_s < s;
  });
}

/// Rates end at a share of the largest rate, as with a range that is too small.
void Saturated(double share, uint64_t, ImuSamples& samples, ImuCalibration&) {
  double largest = 0.0;
  for (const ImuSample& sample : samples) largest = std::max(largest, sample.rate_rad_s.cwiseAbs().maxCoeff());
  const Eigen::Vector3d bound = Eigen::Vector3d::Constant(share * largest);
  for (ImuSample& sample : samples) sample.rate_rad_s = sample.rate_rad_s.cwiseMin(bound).cwiseMax(-bound);
}

void Stuck(double after_s, uint64_t, ImuSamples& samples, ImuCalibration&) {
  const ImuSample* last = nullptr;
  for (ImuSample& sample : samples) {
    if (SecondsAfterFirst(samples, sample) < after_s) continue;
    if (last != nullptr) sample = {sample.t_ns, last->rate_rad_s, last->force_m_s2};
    last = &sample;
  }
}

void Noisy(double factor, uint64_t seed, ImuSamples& samples, ImuCalibration& stated) {
  if (samples.size() < 2) return;
  Random random(Hash(seed, 0x6e6f697365ULL));
  const double step_s = 1e-9 * static_cast<double>(samples[1].t_ns - samples[0].t_ns);
  for (ImuSample& sample : samples) {
    for (int i = 0; i < 3; ++i) {
      sample.rate_rad_s[i] += factor * stated.noise.gyroscope_rad_s_sqrt_hz / std::sqrt(step_s) * Normal(random);
      sample.force_m_s2[i] += factor * stated.noise.accelerometer_m_s2_sqrt_hz / std::sqrt(step_s) * Normal(random);
    }
  }
}

/// The stated rate is that of the samples divided by `share`.
void WrongRate(double share, uint64_t, ImuSamples&, ImuCalibration& stated) { stated.rate_hz /= share; }

void Drifting(double ppm, uint64_t, ImuSamples& samples, ImuCalibration&) {
  const int64_t first_ns = samples.front().t_ns;
  for (ImuSample& sample : samples) {
    const double since_ns = static_cast<double>(sample.t_ns - first_ns);
    sample.t_ns += static_cast<int64_t>(std::floor(1e-6 * ppm * since_ns + 0.5));
  }
}

void Duplicated(double, uint64_t, ImuSamples& samples, ImuCalibration&) {
  ImuSamples all;
  for (size_t i = 0; i < samples.size(); ++i) {
    all.push_back(samples[i]);
    if (i % kEvery == 0) all.push_back(samples[i]);
  }
  samples = std::move(all);
}

void Reordered(double, uint64_t, ImuSamples& samples, ImuCalibration&) {
  for (size_t i = 1; i < samples.size(); i += kEvery) std::swap(samples[i - 1], samples[i]);
}

}  // namespace

const std::vector<SensorFault>& SensorFaults() {
  static const std::vector<SensorFault> kFaults = {
      {"g", 0.0, 0.0, 0.0, InG},
      {"degrees", 0.0, 0.0, 0.0, InDegrees},
      {"exchanged", 0.0, 0.0, 2.0, Exchanged},
      {"inverted", 2.0, 0.0, 2.0, Inverted},
      {"turned", 90.0, -180.0, 180.0, Turned},
      {"extrinsics", 0.0, 0.0, 0.0, InverseExtrinsics},
      {"offset", 20.0, -300.0, 300.0, Offset},
      {"gaps", 0.3, 0.0, 2.0, Gaps},
      {"saturated", 0.5, 0.01, 1.0, Saturated},
      {"stuck", kBegins_s, 0.0, 1000.0, Stuck},
      {"noisy", 100.0, 0.0, 10000.0, Noisy},
      {"rate", 0.5, 0.1, 10.0, WrongRate},
      {"drifting", 1000.0, -20000.0, 20000.0, Drifting},
      {"duplicated", 0.0, 0.0, 0.0, Duplicated},
      {"reordered", 0.0, 0.0, 0.0, Reordered},
  };
  return kFaults;
}

const SensorFault* FindSensorFault(const std::string& name) {
  const std::vector<SensorFault>& faults = SensorFaults();
  const auto found = std::find_if(faults.begin(), faults.end(), [&](const SensorFault& f) { return f.name == name; });
  return found == faults.end() ? nullptr : &*found;
}

}  // namespace plslam::synthetic
