// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/imu_files.h"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <utility>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/datasets/camera_file.h"
#include "core/datasets/dataset_rows.h"
#include "core/errors/error_text.h"
#include "core/files/dataset_error.h"
#include "core/io/trajectories/table_header.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

/// Returns the pose in the body; nullopt if none is stated and the sensor is not the body.
std::optional<SE3> PoseOf(const ImuParts& parts, const SE3& T_b_left, const std::optional<SE3>& T_c_imu,
                          bool is_body) {
  if (parts.T_b_imu) return parts.T_b_imu;
  if (parts.T_c_imu) return T_b_left * *parts.T_c_imu;
  if (T_c_imu) return T_b_left * *T_c_imu;
  return is_body ? std::optional(SE3()) : std::nullopt;
}

/// Whether the camera file has a pose of the left camera in a body, which then is the sensor.
bool HasBody(const SE3& T_b_left) { return !T_b_left.matrix().isIdentity(); }

ImuCalibration With(const SE3& T_b_imu, const ImuParts& parts) {
  ImuCalibration imu;
  imu.T_b_imu = T_b_imu;
  imu.noise = parts.noise.value_or(ImuNoise());
  imu.time_offset_s = parts.time_offset_s.value_or(0.0);
  imu.rate_hz = parts.rate_hz.value_or(0.0);
  return imu;
}

ImuParts PartsOf(const ImuSources& sources, Notes* notes) {
  ImuParts parts;
  for (const std::string& file : sources.files) {
    if (!file.empty()) parts.Complete(ReadImuFile(file, sources.other, notes));
  }
  return parts;
}

std::optional<ImuCalibration> Calibrate(const std::string& name, const SE3& T_b_left, const ImuParts& parts,
                                        const ImuSources& sources, Notes* notes) {
  const bool is_body = parts.is_stated && sources.has_camera_file && HasBody(T_b_left);
  const std::optional<SE3> T_b_imu = PoseOf(parts, T_b_left, sources.T_c_imu, is_body);
  if (!T_b_imu) return std::nullopt;
  if (!parts.noise) {
    notes->Remark(fmt::format(
        "{} has no noise densities: those of a sensor without a data sheet are used (docs/imu.md)", name));
  }
  return With(*T_b_imu, parts);
}

}  // namespace

ImuParts ReadImuFile(const std::string& path, OtherKeys other, Notes* notes) {
  if (!fs::exists(path)) return {};
  if (!ForeignFormat(path).empty()) return ReadForeignImu({path}, std::nullopt, notes);
  const YamlMap yaml = YamlMap::FromFile(path);
  ImuParts parts;
  const bool is_camera_file = yaml.Has("left") || yaml.Has("from");
  if (yaml.IsMap("imu") || (is_camera_file && yaml.Has("imu"))) {
    parts = ReadImuParts(yaml.Map("imu"), other, notes);
  } else if (yaml.IsMap("imu0")) {
    parts = ReadImuParts(yaml.Map("imu0"), other, notes);
  } else if (!is_camera_file) {
    parts = ReadImuParts(yaml, other, notes);
  }
  if (yaml.Has("from")) parts.Complete(ReadForeignImu(FilesNamedBy(yaml), UnitNamedBy(yaml), notes));
  return parts;
}

std::optional<ImuCalibration> CompleteImu(const ImuParts& parts, const SE3& T_b_left) {
  const std::optional<SE3> T_b_imu = PoseOf(parts, T_b_left, std::nullopt, parts.is_stated && HasBody(T_b_left));
  return T_b_imu ? std::optional(With(*T_b_imu, parts)) : std::nullopt;
}

std::optional<ImuCalibration> FindImuCalibration(const std::string& name, const RigCalibration& rig,
                                                 const ImuSources& sources, Notes* notes) {
  return Calibrate(name, rig.left.T_b_cam, PartsOf(sources, notes), sources, notes);
}

namespace {

/// Whether a number without an exponent has digits other than 0 after its point.
bool HasFraction(std::string_view number) {
  const size_t point = number.find('.');
  return point != number.npos && number.find_first_not_of('0', point + 1) != number.npos &&
         number.find_first_of("eE") == number.npos;
}

/// Fails if the samples are less than 0.1 ms or more than 1 s apart in the median.
void CheckUnitOfTime(const std::string& path, const std::vector<ImuSample>& samples) {
  constexpr int64_t kMinStep_ns = 100'000, kMaxStep_ns = 1'000'000'000;
  // Number of samples between two frames, whose usual distance in time is known.
  constexpr double kPerFrame = 10.0;
  std::vector<int64_t> times_ns;
  times_ns.reserve(samples.size());
  for (const ImuSample& sample : samples) times_ns.push_back(sample.t_ns);
  const int64_t step_ns = MedianStep_ns(times_ns);
  if (samples.size() < 3 || (step_ns >= kMinStep_ns && step_ns <= kMaxStep_ns)) return;
  const int decimals = LikelyUnitOfStep(kPerFrame * static_cast<double>(step_ns));
  throw DatasetError(fmt::format(
      "{}: times must be in nanoseconds, but then samples would be {} ns apart in the median, not {} to {} ns{}",
      path, step_ns, kMinStep_ns, kMaxStep_ns,
      decimals == 0 ? "" : fmt::format("; are they in {}?", UnitOfTimeName(decimals))));
}

}  // namespace

std::vector<ImuSample> ReadImuSamples(const std::string& path, Notes* notes) {
  constexpr size_t kColumns = 7;
  std::vector<ImuSample> samples;
  size_t n_early = 0;
  ForEachDatasetRow(path, [&](const TextRow& row) {
    if (row.IsCsvHeader()) return;
    RequireColumns(row, kColumns, "time in nanoseconds, three angular rates and three specific forces");
    if (HasFraction(row.fields[0])) {
      row.Fail(fmt::format("time {} is not a whole number of nanoseconds; is it in seconds?", Shown(row.fields[0])));
    }
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
  CheckUnitOfTime(path, samples);
  return samples;
}

std::string OtherTimesComplaint(const std::vector<ImuSample>& samples, const ImuCalibration& imu, int64_t first_ns,
                                int64_t last_ns) {
  const int64_t begin_ns = samples.front().t_ns + imu.offset_ns(), end_ns = samples.back().t_ns + imu.offset_ns();
  if (end_ns >= first_ns && begin_ns <= last_ns) return "";
  return fmt::format("its samples are of {} s to {} s, but the images of {} s to {} s", SecondsText(begin_ns),
                     SecondsText(end_ns), SecondsText(first_ns), SecondsText(last_ns));
}

void AddImu(const std::string& csv, const std::string& own, const ImuSources& sources, ImageList* list) {
  if (!fs::exists(csv)) return;
  const auto warn = [&](const std::string& reason) {
    list->rig.imu.reset();
    list->notes.Warn(fmt::format("{}: the inertial sensor is not used: {}", csv, reason));
  };
  const ImuParts parts = PartsOf(sources, &list->notes);
  if (!parts.is_stated) return warn(fmt::format("its calibration is missing: write {} (docs/imu.md)", own));
  list->rig.imu = Calibrate(csv, list->rig.left.T_b_cam, parts, sources, &list->notes);
  if (!list->rig.imu) {
    return warn(fmt::format(
        "its pose is not known: write T_c_imu, from the sensor to the left camera (docs/imu.md), to {}", own));
  }
  std::vector<ImuSample> samples = ReadImuSamples(csv, &list->notes);
  const std::string complaint =
      OtherTimesComplaint(samples, *list->rig.imu, list->entries.front().t_ns, list->entries.back().t_ns);
  if (!complaint.empty()) {
    return warn(complaint + ": give its stamps and those of the images one clock, or state time_offset_s");
  }
  list->imu_samples = std::move(samples);
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
