// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/self_calibration_file.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <ctime>
#include <exception>
#include <filesystem>
#include <stdexcept>

#include <Eigen/Cholesky>

#include "core/bus/messages/convert.h"
#include "core/bus/transport/wire.h"
#include "core/errors/log.h"
#include "core/files/atomic_file.h"
#include "core/files/sealed_file.h"
#include "core/geometry/symmetric.h"
#include "plslam/camera_t.hpp"

namespace plslam::vo {
namespace {

constexpr FileKind kCalibration{{'P', 'L', 'S', 'L', 'C', 'A', 'M', 'T'}, 1, "camera"};
// Bound on offsets and covariances; larger values are damage.
constexpr double kLargest = 1000.0;

template <class Matrix>
std::string Text(const Matrix& matrix) {
  std::vector<std::string> numbers;
  for (const double value : matrix.reshaped()) numbers.push_back(fmt::format("{:.17g}", value));
  return fmt::format("[{}]", fmt::join(numbers, ", "));
}

[[noreturn]] void Fail(const std::string& path, const std::string& key, const std::string& what) {
  throw std::runtime_error(
      fmt::format("{}: {} {}; remove the file to estimate the calibration again", path, key, what));
}

template <class Matrix>
Matrix Numbers(const std::string& path, const YAML::Node& map, const std::string& section, const std::string& key) {
  Matrix matrix;
  const std::string name = fmt::format("{}.{}", section, key);
  std::vector<double> numbers;
  try {
    numbers = map[key].as<std::vector<double>>();
  } catch (const YAML::Exception&) {
    Fail(path, name, "is not a list of numbers");
  }
  if (numbers.size() != static_cast<size_t>(matrix.size()))
    Fail(path, name, fmt::format("has {} numbers in place of {}", numbers.size(), matrix.size()));
  for (const double value : numbers) {
    if (!(std::abs(value) <= kLargest)) Fail(path, name, fmt::format("= {}: must be within {}", value, kLargest));
  }
  matrix = Eigen::Map<const Matrix>(numbers.data());
  return matrix;
}

template <class Matrix>
Matrix Covariance(const std::string& path, const YAML::Node& map, const std::string& name) {
  Matrix matrix = Numbers<Matrix>(path, map, name, "covariance_px2");
  const bool symmetric = (matrix - matrix.transpose()).norm() <= 1e-9 * matrix.norm();
  if (!symmetric || !IsPositiveDefinite<Matrix::RowsAtCompileTime>(matrix))
    Fail(path, name + ".covariance_px2", "is not a covariance");
  return matrix;
}

}  // namespace

std::string NameOfCalibration(const std::vector<uint8_t>& camera) {
  const std::optional<camera_t> message = bus::Decoded<camera_t>(camera);
  if (!message) throw std::runtime_error("a camera's message is damaged");
  const Seal seal = MakeSeal(kCalibration, bus::RigBytes(*message));
  return fmt::format("{:02x}", fmt::join(seal.checksum.begin(), seal.checksum.begin() + 8, ""));
}

void WriteSelfCalibration(const std::string& path, const std::string& calibration, const SelfCalibration& learned) {
  std::string text = fmt::format(
      "# Self-calibration of this rig by vo_process, used only with the calibration below. Remove the file "
      "to estimate it again.\ncalibration: {}\nwritten: {:%Y-%m-%dT%H:%M:%SZ}\n",
      calibration, fmt::gmtime(std::time(nullptr)));
  if (learned.rows) {
    text += fmt::format("rows:\n  offsets_px: {}\n  covariance_px2: {}\n", Text(learned.rows->offsets_px),
                        Text(learned.rows->covariance_px2));
  }
  if (learned.disparities) {
    text += fmt::format("disparities:\n  coefficients_px: {}\n  covariance_px2: {}\n",
                        Text(learned.disparities->coefficients_px), Text(learned.disparities->covariance_px2));
  }
  WriteFileAtomically(path, text);
}

std::optional<SelfCalibration> ReadSelfCalibration(const std::string& path, const std::string& calibration) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  YAML::Node file;
  try {
    file = YAML::LoadFile(path);
    if (!file.IsMap() || !file["calibration"].IsDefined()) Fail(path, "calibration", "is missing");
    if (file["calibration"].as<std::string>() != calibration) return std::nullopt;
  } catch (const YAML::Exception& error) {
    Fail(path, "the file", fmt::format("is not YAML ({})", error.what()));
  }
  SelfCalibration learned;
  if (const YAML::Node rows = file["rows"]; rows.IsDefined()) {
    learned.rows = {Numbers<RowField::Coefficients>(path, rows, "rows", "offsets_px"),
                    Covariance<Eigen::Matrix<double, 6, 6>>(path, rows, "rows")};
  }
  if (const YAML::Node disparities = file["disparities"]; disparities.IsDefined()) {
    learned.disparities = {Numbers<Eigen::Vector3d>(path, disparities, "disparities", "coefficients_px"),
                           Covariance<Eigen::Matrix3d>(path, disparities, "disparities")};
  }
  return learned;
}

void LoadLearned(const std::string& path, const std::vector<uint8_t>& camera, Odometry& odometry) {
  if (path.empty()) return;
  try {
    const auto learned = ReadSelfCalibration(path, NameOfCalibration(camera));
    if (!learned) return;
    odometry.Begin(*learned);
    LogInfo("starting with the self-calibration of {}", path);
  } catch (const std::exception& error) {
    LogWarning("the self-calibration file is not used: {}", error.what());
  }
}

void KeepLearned(const std::string& path, const std::vector<uint8_t>& camera,
                 const std::optional<Odometry>& odometry) {
  if (path.empty() || !odometry) return;
  const SelfCalibration learned = odometry->calibration().learned();
  if (!learned.rows && !learned.disparities) return;
  try {
    WriteSelfCalibration(path, NameOfCalibration(camera), learned);
  } catch (const std::exception& error) {
    LogWarning("the self-calibration file is not written: {}", error.what());
  }
}

}  // namespace plslam::vo
