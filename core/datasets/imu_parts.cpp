// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/imu_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace plslam {
namespace {

constexpr double kMaxImuRate_hz = 100000.0;
// Bounds of noise densities and random walks, beyond which they are in other units.
constexpr double kMostNoise = 10.0;
constexpr const char* kOwnTime = "time_offset_s";
constexpr ImuKeys kOwnKeys{
    {"gyroscope_noise_density", "gyroscope_random_walk", "accelerometer_noise_density", "accelerometer_random_walk"},
    "rate_hz",
    kOwnTime,
    1.0};

double ReadNoise(const YamlMap& yaml, const char* key) {
  double value = 0.0;
  if (yaml.WholeTexts(key).size() == 1) {
    value = yaml.Number(key);
  } else {
    const std::vector<double> axes = yaml.Numbers(key, 3, 3);
    value = *std::max_element(axes.begin(), axes.end());
  }
  if (!(value > 0.0 && value <= kMostNoise)) {
    yaml.Fail(key, fmt::format("= {} is not above 0 and at most {}: state it in SI units and per root of Hz", value,
                               kMostNoise));
  }
  return value;
}

std::optional<double> ReadImuRate(const YamlMap& yaml, const char* key) {
  if (key == nullptr || !yaml.Has(key)) return std::nullopt;
  const double value = yaml.Number(key);
  if (!(value > 0.0 && value <= kMaxImuRate_hz)) {
    yaml.Fail(key, fmt::format("= {} is not above 0 and at most {}", value, kMaxImuRate_hz));
  }
  return value;
}

std::optional<double> ReadTimeOffset(const YamlMap& yaml, const char* key, double unit_s) {
  if (key == nullptr || !yaml.Has(key)) return std::nullopt;
  const double value = yaml.Number(key);
  if (!(std::abs(unit_s * value) <= kMaxImuOffset_s)) {
    const double most = kMaxImuOffset_s / std::abs(unit_s);
    yaml.Fail(key, fmt::format("= {} is not within -{} to {}, which is {} s", value, most, most, kMaxImuOffset_s));
  }
  return unit_s * value + 0.0;  // without a sign of zero
}

/// Sensors after the first one of a file of Kalibr refer to that one.
void RequireFirstSensor(const YamlMap& yaml) {
  if (yaml.Has("T_i_b") && !yaml.Transform("T_i_b").matrix().isIdentity(1e-6)) {
    yaml.Fail("T_i_b", "is not the identity, as that of Kalibr's imu0 is: give imu0, or its pose as T_b_imu");
  }
  if (yaml.Has("time_offset") && yaml.Number("time_offset") != 0.0) {
    yaml.Fail("time_offset", fmt::format("= {} is not 0, as that of Kalibr's imu0 is: give {} instead",
                                         yaml.Number("time_offset"), kOwnTime));
  }
}

/// Scale and misalignment of the axes, by Kalibr and OpenVINS.
void WarnOfIntrinsics(const YamlMap& yaml, Notes* notes) {
  std::string key;
  for (const char* map : {"accelerometers", "gyroscopes"}) {
    if (yaml.Has(map)) key = map;
  }
  for (const char* matrix : {"Tw", "Ta", "R_IMUtoGYRO", "R_IMUtoACC"}) {
    if (!yaml.Has(matrix)) continue;
    const std::vector<double> m = yaml.Matrix(matrix, 9, 9);
    if (!Eigen::Map<const Eigen::Matrix3d>(m.data()).isIdentity(1e-4)) key = matrix;
  }
  if (key.empty()) return;
  notes->Warn(
      fmt::format("{}: {} is not applied, since samples are used as they are: calibrate with Kalibr's model "
                  "'calibrated', or correct the samples by it",
                  yaml.Place(key), key));
}

}  // namespace

void ImuParts::Complete(const ImuParts& other) {
  is_stated = is_stated || other.is_stated;
  if (!has_pose()) {
    T_b_imu = other.T_b_imu;
    T_c_imu = other.T_c_imu;
  }
  if (!noise) noise = other.noise;
  if (!time_offset_s) time_offset_s = other.time_offset_s;
  if (!rate_hz) rate_hz = other.rate_hz;
}

ImuParts ReadImuKeys(const YamlMap& yaml, const ImuKeys& keys) {
  ImuParts parts;
  parts.is_stated = true;
  if (std::any_of(keys.noise.begin(), keys.noise.end(), [&](const char* key) { return yaml.Has(key); })) {
    parts.noise = ImuNoise{ReadNoise(yaml, keys.noise[0]), ReadNoise(yaml, keys.noise[1]),
                           ReadNoise(yaml, keys.noise[2]), ReadNoise(yaml, keys.noise[3])};
  }
  parts.rate_hz = ReadImuRate(yaml, keys.rate);
  parts.time_offset_s = ReadTimeOffset(yaml, keys.time, keys.time_offset_s);
  return parts;
}

ImuParts ReadImuParts(const YamlMap& yaml, OtherKeys other, Notes* notes) {
  if (other == OtherKeys::kRefused && !yaml.Has("T_BS")) {
    yaml.AllowOnly({"T_b_imu",
                    "T_c_imu",
                    "gyroscope_noise_density",
                    "gyroscope_random_walk",
                    "accelerometer_noise_density",
                    "accelerometer_random_walk",
                    kOwnTime,
                    "rate_hz",
                    "T_BS",
                    "update_rate",
                    "rostopic",
                    "model",
                    "T_i_b",
                    "time_offset",
                    "sensor_type",
                    "comment",
                    "accelerometers",
                    "gyroscopes",
                    "Tw",
                    "Ta",
                    "Tg",
                    "R_IMUtoGYRO",
                    "R_IMUtoACC"});
  }
  RequireFirstSensor(yaml);
  WarnOfIntrinsics(yaml, notes);
  ImuParts parts = ReadImuKeys(yaml, kOwnKeys);
  if (!parts.rate_hz) parts.rate_hz = ReadImuRate(yaml, "update_rate");
  if (!parts.time_offset_s) parts.time_offset_s = ReadTimeOffset(yaml, "imu_time_shift", -1.0);
  for (const char* key : {"T_b_imu", "T_BS"}) {
    if (!parts.T_b_imu && yaml.Has(key)) parts.T_b_imu = yaml.Transform(key);
  }
  if (!parts.T_b_imu && yaml.Has("T_c_imu")) parts.T_c_imu = yaml.Transform("T_c_imu");
  return parts;
}

}  // namespace plslam
