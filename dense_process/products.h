// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/map/vertical.h"
#include "dense_process/dense_map.h"
#include "dense_process/ground_grid.h"
#include "dense_process/surface.h"

namespace plslam::dense {

/// Results computed from a dense map at one time.
struct Products {
  SE3 T_level_w;
  Vertical vertical;
  bool has_floor = false;
  double floor_m = 0.0;  ///< height of the floor below the first camera, in the level frame
  Surface surface;       ///< in w, the frame of trajectory.tum
  Volume volume;         ///< of the level frame, its voxels centred at voxel_m * (i + 0.5)
  GroundGrid grid;       ///< empty without a floor
  std::string no_grid;   ///< why there is none although there is a floor, in one sentence; empty: there is one
  std::vector<Eigen::Vector3d> path;  ///< positions of the camera in the level frame
};

/// Returns the positions of the keyframes in w in their order, with points every half voxel between neighbours of one
/// session that are nearer than `kNearKeyframes` voxels. Over longer gaps, of lost tracking or of a map that has removed
/// keyframes, the way between them is unknown.
std::vector<Eigen::Vector3d> PathOf(const KeyframePoses& poses, double voxel_m);

inline constexpr double kNearKeyframes = 20.0;

/// `path_w`: positions of the camera in w.
Products MakeProducts(const DenseMap& map, const KeyframePoses& poses, const Vertical& vertical,
                      const std::vector<Eigen::Vector3d>& path_w, double robot_height_m);

/// The grid of products with a floor, as the bus carries it.
OccupancyGrid ToOccupancyGrid(const Products& products);

/// Binary little-endian PLY: vertices with x, y, z, nx, ny, nz, red, green, blue; with faces, or as a cloud.
std::string ToPly(const Surface& surface, bool with_faces);
/// OBJ, as text: "v x y z r g b" with the grey of the vertex as a colour between 0 and 1, normals, and triangles.
std::string ToObj(const Surface& surface);
/// PGM as nav2's map_server reads it: row 0 has the largest y.
std::string ToPgm(const GroundGrid& grid);
/// Its YAML file; the origin has full precision.
std::string ToMapYaml(const GroundGrid& grid, const std::string& image);

/// Files for one kind of reader.
enum class ProductKind {
  kCloud,    ///< cloud.ply
  kMesh,     ///< mesh.ply
  kMeshObj,  ///< mesh.obj: the same for programs that read no PLY; for exports
  kOctoMap,  ///< map.bt, map.ot
  kGrid,     ///< map.pgm, map.yaml, map_distance.png, map_height.png, if there is a floor; path.csv
};

/// All kinds, by the names that `plslam export --format` has for them.
inline constexpr std::pair<const char*, ProductKind> kProductKinds[] = {{"cloud", ProductKind::kCloud},
                                                                        {"mesh", ProductKind::kMesh},
                                                                        {"mesh-obj", ProductKind::kMeshObj},
                                                                        {"octomap", ProductKind::kOctoMap},
                                                                        {"grid", ProductKind::kGrid}};

/// Writes the files of one kind to the folder, and returns their names. Each file is written completely or not at all;
/// throws std::runtime_error with one sentence that names it.
std::vector<std::string> WriteProducts(const std::filesystem::path& folder, const Products& products,
                                       ProductKind kind);
/// Writes the frames of all of them: frames.json.
void WriteFrames(const std::filesystem::path& folder, const Products& products);

}  // namespace plslam::dense
