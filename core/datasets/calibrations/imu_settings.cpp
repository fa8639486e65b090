// SPDX-License-Identifier: BSD-3-Clause
// The inertial sensor in settings of other programs. readers.h cites where units and signs are defined.
#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/datasets/asl_sensor.h"
#include "core/datasets/calibrations/readers.h"
#include "core/datasets/imu_files.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

/// The poses of the cameras are those in the sensor.
ImuParts AsBody(ImuParts parts) {
  parts.T_b_imu = SE3();
  return parts;
}

/// Whether a switch in a file, if it is there, is on.
bool IsOn(const YamlMap& file, const char* key) {
  if (!file.Has(key)) return true;
  const std::string text = file.Text(key);
  return text != "0" && text != "false" && text != "False";
}

/// Returns the files with the noise that may belong to a camchain, the likeliest first.
std::vector<std::string> NoiseBeside(const fs::path& camchain) {
  std::vector<std::string> paths;
  const std::string name = camchain.filename().string();
  for (const auto& [cameras, imu] : {std::pair<std::string_view, std::string_view>("camchain-imucam", "imu"),
                                     std::pair<std::string_view, std::string_view>("imucam_chain", "imu_chain")}) {
    const size_t at = name.find(cameras);
    if (at == std::string::npos) continue;
    std::string other = name;
    paths.push_back((camchain.parent_path() / other.replace(at, cameras.size(), imu)).string());
  }
  paths.push_back((camchain.parent_path() / "imu.yaml").string());
  return paths;
}

}  // namespace

ImuParts ReadKalibrImu(const YamlMap& file, Notes* notes) {
  ImuParts parts = ReadCamchainImu(file.path());
  if (!parts.is_stated) return parts;
  for (const std::string& beside : NoiseBeside(file.path())) {
    if (!fs::exists(beside)) continue;
    parts.Complete(ReadImuFile(beside, OtherKeys::kRefused, notes));
    break;
  }
  return parts;
}

ImuParts ReadOrbSlamImu(const YamlMap& file, Notes*) {
  constexpr ImuKeys kKeys{{"IMU.NoiseGyro", "IMU.GyroWalk", "IMU.NoiseAcc", "IMU.AccWalk"}, "IMU.Frequency"};
  for (const char* pose : {"IMU.T_b_c1", "Tbc"}) {
    if (!file.Has(pose)) continue;
    ImuParts parts = ReadImuKeys(file, kKeys);
    parts.T_c_imu = file.Transform(pose).Inverse();
    return parts;
  }
  return {};
}

ImuParts ReadVinsImu(const YamlMap& file, Notes* notes) {
  if (!file.Has("imu") || !IsOn(file, "imu")) return {};
  if (file.Has("gyr_n")) {
    notes->Remark(
        fmt::format("{}: noises of VINS-Fusion are per sample, at a rate that the file does not state, and "
                    "not used: state densities in an imu.yaml",
                    file.Place("gyr_n")));
  }
  return AsBody(ReadImuKeys(file, {.noise = {"", "", "", ""}, .time = "td", .time_offset_s = -1.0}));
}

ImuParts ReadBasaltImu(const YamlMap& file, Notes*) {
  constexpr ImuKeys kKeys{{"gyro_noise_std", "gyro_bias_std", "accel_noise_std", "accel_bias_std"},
                          "imu_update_rate",
                          "cam_time_offset_ns",
                          -1e-9};
  return AsBody(ReadImuKeys(file.Map("value0"), kKeys));
}

ImuParts ReadOkvisImu(const YamlMap& file, Notes*) {
  for (const char* map : {"imu_params", "imu_parameters"}) {
    if (!file.IsMap(map)) continue;
    const YamlMap imu = file.Map(map);
    if (!IsOn(imu, "use")) return {};
    ImuParts parts = ReadImuKeys(imu, {{"sigma_g_c", "sigma_gw_c", "sigma_a_c", "sigma_aw_c"}, "imu_rate"});
    for (const char* delay : {"imageDelay", "camera_params.image_delay", "camera_parameters.image_delay"}) {
      if (!file.Has(delay)) continue;
      parts.time_offset_s = ReadImuKeys(file, {.noise = {"", "", "", ""}, .time = delay}).time_offset_s;
    }
    return AsBody(parts);
  }
  return {};
}

ImuParts ReadSvoImu(const YamlMap& file, Notes*) {
  constexpr ImuKeys kKeys{
      {"sigma_omega_c", "sigma_omega_bias_c", "sigma_acc_c", "sigma_acc_bias_c"}, "imu_rate", "delay_imu_cam", 1.0};
  return file.IsMap("imu_params") ? AsBody(ReadImuKeys(file.Map("imu_params"), kKeys)) : ImuParts();
}

ImuParts ReadAirSlamImu(const YamlMap& file, Notes* notes) {
  if (!file.Has("use_imu") || !IsOn(file, "use_imu")) return {};
  return AsBody(ReadImuParts(file, OtherKeys::kIgnored, notes));
}

ImuParts ReadKimeraImu(const YamlMap& file, Notes* notes) {
  return ReadImuFile((fs::path(file.path()).parent_path() / "ImuParams.yaml").string(), OtherKeys::kIgnored, notes);
}

}  // namespace plslam
