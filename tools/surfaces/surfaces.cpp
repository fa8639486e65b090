// SPDX-License-Identifier: BSD-3-Clause
#include "tools/surfaces/surfaces.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/io/maps/map_file.h"
#include "core/map/vertical.h"
#include "core/run/result_files.h"
#include "dense_process/dense_map.h"
#include "dense_process/products.h"

namespace plslam::surfaces {

std::vector<std::string> WriteSurfaces(const SurfacesRequest& request) {
  const StoredMap stored = ReadMapFile(request.map);
  const dense::DenseMap surfaces = dense::DenseMap::Read(request.map + ".surfaces", 0.0);
  const dense::KeyframePoses poses = dense::PosesOf(stored.map);
  if (surfaces.n_submaps() > 0 && surfaces.CountUnplaced(poses) == surfaces.n_submaps()) {
    throw std::runtime_error(fmt::format(
        "{}.surfaces are the surfaces of another map: {} has none of their keyframes; remove them, or map again with "
        "--dense",
        request.map, request.map));
  }
  const std::vector<double>& up_c = request.up_c.empty() ? surfaces.robot().up_c : request.up_c;
  const dense::Products products =
      dense::MakeProducts(surfaces, poses, VerticalOf(stored.map, up_c), dense::PathOf(poses, surfaces.voxel_m()),
                          request.robot_height_m.value_or(surfaces.robot().height_m));
  std::filesystem::create_directories(request.out);
  dense::WriteFrames(request.out, products);
  std::vector<std::string> names;
  for (const auto& [name, kind] : dense::kProductKinds) {
    if (std::ranges::find(request.kinds, std::string_view(name)) == request.kinds.end()) continue;
    if (kind == dense::ProductKind::kGrid && !products.no_grid.empty()) {
      throw std::runtime_error(fmt::format("{}: {}", request.map, products.no_grid));
    }
    if (kind == dense::ProductKind::kGrid && !products.has_floor) {
      throw std::runtime_error(fmt::format(
          "{}: no grid: the map has no horizontal surface that could be the floor; cloud, mesh and octomap need none",
          request.map));
    }
    for (std::string& file : dense::WriteProducts(request.out, products, kind)) names.push_back(std::move(file));
  }
  names.emplace_back(result_file::kSurfaceFrames);
  return names;
}

}  // namespace plslam::surfaces
