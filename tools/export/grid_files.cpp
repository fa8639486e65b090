// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/grid_files.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "core/errors/error_text.h"
#include "core/run/result_files.h"

namespace plslam::exports {
namespace {

/// Reads PGM with 8 bits; its first row becomes the last one.
void ReadPgm(const std::string& path, OccupancyGrid& grid) {
  std::ifstream file = OpenInput(path);
  std::string magic;
  int most = 0;
  file >> magic >> grid.n_columns >> grid.n_rows >> most;
  const int64_t size = int64_t{grid.n_columns} * grid.n_rows;
  if (!file || magic != "P5" || most != 255 || grid.n_columns <= 0 || grid.n_rows <= 0 ||
      size > GridTiles::kMostCells) {
    throw std::runtime_error(path + ": is not a grid of dense_process (P5, 255 grey values)");
  }
  file.get();
  grid.cells.resize(static_cast<size_t>(size));
  for (int row = grid.n_rows - 1; row >= 0 && file; --row) {
    file.read(reinterpret_cast<char*>(grid.cells.data()) + int64_t{row} * grid.n_columns, grid.n_columns);
  }
  if (!file) throw std::runtime_error(path + ": ends early");
}

}  // namespace

std::optional<OccupancyGrid> ReadGridFiles(const std::string& folder) {
  const std::filesystem::path from(folder);
  const std::string yaml = from / result_file::kGridMetadata, frames = from / result_file::kSurfaceFrames;
  if (!std::filesystem::exists(yaml)) return std::nullopt;
  OccupancyGrid grid;
  try {
    const YAML::Node map = YAML::LoadFile(yaml);
    grid.cell_m = map["resolution"].as<double>();
    if (!(grid.cell_m > 0.0)) throw std::runtime_error("resolution is not positive");
    const auto cell_of = [&](int axis) {
      return static_cast<int>(std::lround(map["origin"][axis].as<double>() / grid.cell_m));
    };
    grid.first_column = cell_of(0);
    grid.first_row = cell_of(1);
    ReadPgm(from / map["image"].as<std::string>(), grid);
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(fmt::format("{}: {}", yaml, error.what()));
  }
  std::ifstream file = OpenInput(frames);
  try {
    const nlohmann::json json = nlohmann::json::parse(file);
    const std::vector<double> q = json.at("T_level_w").at("q_wxyz"), t = json.at("T_level_w").at("t_m");
    grid.T_w_level =
        SE3(Eigen::Quaterniond(q.at(0), q.at(1), q.at(2), q.at(3)), Eigen::Vector3d(t.at(0), t.at(1), t.at(2)))
            .Inverse();
    grid.floor_m = json.at("floor_m");
  } catch (const std::exception& error) {
    throw std::runtime_error(fmt::format("{}: {}", frames, error.what()));
  }
  return grid;
}

}  // namespace plslam::exports
