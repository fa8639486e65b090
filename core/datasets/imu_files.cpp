// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/imu_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "core/datasets/dataset_rows.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxImuRate_hz = 100000.0;
// Bounds of noise densities and random walks, beyond which they are in other units.
constexpr double kMostNoise = 10.0;

double ReadNoise(const YamlMap& yaml, const char* key) {
  const double value = yaml.Number(key);
  if (!(value > 0.0 && value <= kMostNoise)) {
    yaml.Fail(key, fmt::format("= {} is not above 0 and at most {}: state it in SI units and per root of Hz", value,
                               kMostNoise));
  }
  return value;
}

std::optional<SE3> ReadImuPose(const YamlMap& yaml, const SE3& T_b_left) {
  for (const char* key : {"T_b_imu", "T_BS"}) {
    if (yaml.Has(key)) return yaml.Transform(key);
  }
  return yaml.Has("T_c_imu") ? std::optional(T_b_left * yaml.Transform("T_c_imu")) : std::nullopt;
}

/// Returns nullopt if none of the densities is stated.
std::optional<ImuNoise> ReadImuNoise(const YamlMap& yaml) {
  constexpr std::array kKeys = {"gyroscope_noise_density", "gyroscope_random_walk", "accelerometer_noise_density",
                                "accelerometer_random_walk"};
  if (std::none_of(kKeys.begin(), kKeys.end(), [&](const char* key) { return yaml.Has(key); })) return std::nullopt;
  return ImuNoise{ReadNoise(yaml, kKeys[0]), ReadNoise(yaml, kKeys[1]), ReadNoise(yaml, kKeys[2]),
                  ReadNoise(yaml, kKeys[3])};
}

constexpr const char* kDefaultNoise =
    "has no noise densities: those of a sensor without a data sheet are used (docs/imu.md)";

double ReadImuRate(const YamlMap& yaml) {
  for (const char* key : {"rate_hz", "update_rate"}) {
    if (!yaml.Has(key)) continue;
    const double value = yaml.Number(key);
    if (value > 0.0 && value <= kMaxImuRate_hz) return value;
    yaml.Fail(key, fmt::format("= {} is not above 0 and at most {}", value, kMaxImuRate_hz));
  }
  return 0.0;
}

double ReadTimeOffset(const YamlMap& yaml) {
  if (!yaml.Has("time_offset_s")) return 0.0;
  const double value = yaml.Number("time_offset_s");
  if (std::abs(value) <= kMaxImuOffset_s) return value;
  yaml.Fail("time_offset_s", fmt::format("= {} is not within -{} to {} s", value, kMaxImuOffset_s, kMaxImuOffset_s));
}

}  // namespace

ImuCalibration ReadImuCalibration(const YamlMap& yaml, const SE3& T_b_left, Notes* notes) {
  ImuCalibration imu;
  imu.T_b_imu = ReadImuPose(yaml, T_b_left).value_or(SE3());
  const std::optional<ImuNoise> noise = ReadImuNoise(yaml);
  if (noise) {
    imu.noise = *noise;
  } else {
    notes->Remark(fmt::format("{}: the inertial sensor {}", yaml.path(), kDefaultNoise));
  }
  imu.time_offset_s = ReadTimeOffset(yaml);
  imu.rate_hz = ReadImuRate(yaml);
  return imu;
}

std::optional<ImuCalibration> FindImuCalibration(const std::string& name, const RigCalibration& rig,
                                                 const ImuSources& sources, Notes* notes) {
  const SE3& T_b_left = rig.left.T_b_cam;
  ImuCalibration imu;
  std::optional<SE3> T_b_imu;
  std::optional<ImuNoise> noise;
  if (!sources.file.empty() && fs::exists(sources.file)) {
    const YamlMap whole = YamlMap::FromFile(sources.file);
    const YamlMap yaml = whole.IsMap("imu") ? whole.Map("imu") : whole;
    T_b_imu = ReadImuPose(yaml, T_b_left);
    noise = ReadImuNoise(yaml);
    imu.time_offset_s = ReadTimeOffset(yaml);
    imu.rate_hz = ReadImuRate(yaml);
    const bool left_has_pose = sources.has_camera_file && !T_b_left.matrix().isIdentity();
    if (!T_b_imu && !sources.T_c_imu && left_has_pose) T_b_imu = SE3();
  }
  if (!T_b_imu && sources.T_c_imu) T_b_imu = T_b_left * *sources.T_c_imu;
  if (!T_b_imu) return std::nullopt;
  if (!noise) notes->Remark(fmt::format("{} {}", name, kDefaultNoise));
  imu.T_b_imu = *T_b_imu;
  imu.noise = noise.value_or(ImuNoise());
  return imu;
}

std::vector<ImuSample> ReadImuSamples(const std::string& path, Notes* notes) {
  constexpr size_t kColumns = 7;
  std::vector<ImuSample> samples;
  size_t n_early = 0;
  ForEachDatasetRow(path, [&](const TextRow& row) {
    if (row.IsCsvHeader()) return;
    RequireColumns(row, kColumns, "time in nanoseconds, three angular rates and three specific forces");
    ImuSample sample;
    sample.t_ns = row.Scaled(0, 0);
    for (size_t i = 0; i < 3; ++i) {
      sample.rate_rad_s[static_cast<Eigen::Index>(i)] = row.Number(1 + i);
      sample.force_m_s2[static_cast<Eigen::Index>(i)] = row.Number(4 + i);
    }
    if (!samples.empty() && sample.t_ns <= samples.back().t_ns) {
      ++n_early;
    } else {
      samples.push_back(sample);
    }
  });
  if (samples.empty()) throw DatasetError(path + ": has no samples");
  if (n_early > 0) {
    notes->Warn(
        fmt::format("{}: {} samples are not used, because their times are not after the one before", path, n_early));
  }
  return samples;
}

void AddImu(const std::string& csv, const std::string& yaml, ImageList* list) {
  if (!fs::exists(csv)) return;
  if (!list->rig.imu && fs::exists(yaml)) {
    list->rig.imu = ReadImuCalibration(YamlMap::FromFile(yaml), list->rig.left.T_b_cam, &list->notes);
  }
  if (!list->rig.imu) {
    list->notes.Warn(
        fmt::format("{}: the inertial sensor is not used, because its calibration is missing: write {}", csv, yaml));
    return;
  }
  list->imu_samples = ReadImuSamples(csv, &list->notes);
}

std::string ImuFileText(const ImuCalibration& imu) {
  const Eigen::Matrix4d T = imu.T_b_imu.matrix();
  std::string text = "imu:\n  T_b_imu: [";
  for (int i = 0; i < 12; ++i) {
    text += fmt::format("{}{}", i == 0 ? "" : i % 4 == 0 ? ",\n            " : ", ", T(i / 4, i % 4));
  }
  text += fmt::format(
      "]\n  gyroscope_noise_density: {}\n  gyroscope_random_walk: {}\n  accelerometer_noise_density: {}\n"
      "  accelerometer_random_walk: {}\n  time_offset_s: {}\n",
      imu.noise.gyroscope_rad_s_sqrt_hz, imu.noise.gyroscope_walk_rad_s2_sqrt_hz,
      imu.noise.accelerometer_m_s2_sqrt_hz, imu.noise.accelerometer_walk_m_s3_sqrt_hz, imu.time_offset_s);
  return imu.rate_hz > 0.0 ? text + fmt::format("  rate_hz: {}\n", imu.rate_hz) : text;
}

}  // namespace plslam
