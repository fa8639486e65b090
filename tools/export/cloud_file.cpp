// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/cloud_file.h"

#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string_view>

#include "core/errors/error_text.h"
#include "core/run/result_files.h"

namespace plslam::exports {
namespace {

static_assert(std::endian::native == std::endian::little, "other machines must turn the bytes round here");

constexpr std::string_view kCount = "element vertex ";
/// The properties of a vertex, in their order: six floats, and three bytes of which all have the grey value.
constexpr std::array<std::string_view, 9> kProperties{
    "property float x",  "property float y",   "property float z",     "property float nx",  "property float ny",
    "property float nz", "property uchar red", "property uchar green", "property uchar blue"};
constexpr size_t kVertex_bytes = 6 * sizeof(float) + 3;

/// Reads the header and returns the number of vertices; 0 if it is another one.
size_t ReadHeader(std::istream& file) {
  const auto has = [&](std::string_view expected) {
    std::string line;
    return std::getline(file, line) && line == expected;
  };
  std::string line;
  if (!has("ply") || !has("format binary_little_endian 1.0") || !std::getline(file, line)) return 0;
  if (!line.starts_with(kCount)) return 0;
  const size_t n = std::strtoull(line.c_str() + kCount.size(), nullptr, 10);
  for (const std::string_view property : kProperties) {
    if (!has(property)) return 0;
  }
  return has("end_header") ? n : 0;
}

SurfacePoint ToPoint(const char* bytes) {
  std::array<float, 6> values{};
  std::memcpy(values.data(), bytes, sizeof(values));
  return {{values[0], values[1], values[2]},
          RoundedNormal({values[3], values[4], values[5]}),
          static_cast<uint8_t>(bytes[sizeof(values)])};
}

}  // namespace

std::optional<std::vector<SurfacePoint>> ReadCloudFile(const std::string& folder) {
  const std::string path = std::filesystem::path(folder) / result_file::kCloud;
  if (!std::filesystem::exists(path)) return std::nullopt;
  std::ifstream file = OpenInput(path);
  const size_t n = ReadHeader(file);
  const size_t head = n > 0 ? static_cast<size_t>(file.tellg()) : 0;
  if (n == 0 || n > (std::filesystem::file_size(path) - head) / kVertex_bytes) {
    throw std::runtime_error(path + ": is not a cloud of dense_process");
  }
  std::vector<SurfacePoint> points(n);
  std::string bytes(n * kVertex_bytes, '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
    throw std::runtime_error(path + ": ends early");
  }
  for (size_t i = 0; i < n; ++i) points[i] = ToPoint(bytes.data() + i * kVertex_bytes);
  return points;
}

}  // namespace plslam::exports
