// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/products.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include <octomap/octomap.h>
#include <opencv2/core.hpp>

#include "core/files/atomic_file.h"
#include "core/files/bytes.h"
#include "core/io/images/png_codec.h"
#include "core/run/result_files.h"

namespace plslam::dense {
namespace {

/// Millimetres in 16 bits; 65535: unknown or farther.
cv::Mat InMillimetres(const cv::Mat& metres) {
  cv::Mat millimetres(metres.size(), CV_16UC1, cv::Scalar(std::numeric_limits<uint16_t>::max()));
  for (int y = 0; y < metres.rows; ++y) {
    for (int x = 0; x < metres.cols; ++x) {
      const float value = 1000.0F * metres.at<float>(y, x);
      if (value >= 0.0F && value < 65534.5F)
        millimetres.at<uint16_t>(y, x) = static_cast<uint16_t>(std::lround(value));
    }
  }
  return millimetres;
}

cv::Mat TopDown(const cv::Mat& image) {
  cv::Mat flipped;
  cv::flip(image, flipped, 0);
  return flipped;
}

// Keys of OctoMap have 16 bits.
constexpr double kOctoMapKeys = 32768.0;

octomap::OcTree ToOctree(const Volume& volume) {
  octomap::OcTree tree(volume.voxel_m());
  volume.Visit([&](const Volume::Voxel& voxel) {
    const Content content = ContentOf(voxel, volume.voxel_m());
    if (content == Content::kUnknown) return;
    const Eigen::Vector3d p = volume.Centre(voxel.index) + Eigen::Vector3d::Constant(0.5 * volume.voxel_m());
    const float log_odds =
        content == Content::kOccupied ? tree.getClampingThresMaxLog() : tree.getClampingThresMinLog();
    if (tree.setNodeValue(p.x(), p.y(), p.z(), log_odds, true) == nullptr) {
      throw std::runtime_error(fmt::format(
          "no OctoMap: with voxels of {} m it reaches {:.0f} m from the first keyframe, and the surfaces go "
          "farther; choose larger ones (dense.voxel_m)",
          volume.voxel_m(), kOctoMapKeys * volume.voxel_m()));
    }
  });
  tree.updateInnerOccupancy();
  return tree;
}

std::string PathCsv(const std::vector<Eigen::Vector3d>& path) {
  std::string text = "x,y\n";
  for (const Eigen::Vector3d& p : path) text += fmt::format("{:.6f},{:.6f}\n", p.x(), p.y());
  return text;
}

std::string FramesJson(const Products& products) {
  const Eigen::Quaterniond& q = products.T_level_w.rotation();
  const Eigen::Vector3d& t = products.T_level_w.translation();
  nlohmann::ordered_json json;
  json["T_level_w"] = {{"q_wxyz", {q.w(), q.x(), q.y(), q.z()}}, {"t_m", {t.x(), t.y(), t.z()}}};
  json["up_from"] = NameOf(products.vertical.source);
  json["up_n"] = products.vertical.n;
  json["up_sigma_deg"] = products.vertical.sigma_rad / kRadPerDeg;
  if (products.has_floor) json["floor_m"] = products.floor_m;
  json["voxel_m"] = products.volume.voxel_m();
  json["w"] = {result_file::kCloud, result_file::kMesh, result_file::kTrajectory.tum};
  json["level"] = {result_file::kOccupiedVoxels, result_file::kVoxels,  result_file::kGrid,
                   result_file::kDistances,      result_file::kHeights, result_file::kPath};
  return json.dump(2) + "\n";
}

}  // namespace

std::vector<Eigen::Vector3d> PathOf(const KeyframePoses& poses, double voxel_m) {
  std::vector<Eigen::Vector3d> path;
  const KeyframePoses::value_type* previous = nullptr;
  for (const auto& keyframe : poses) {
    const Eigen::Vector3d& to = keyframe.second.translation();
    const bool continues = previous != nullptr && previous->first.first == keyframe.first.first;
    const Eigen::Vector3d from = continues ? previous->second.translation() : to;
    if ((to - from).norm() < kNearKeyframes * voxel_m) {
      const int n = static_cast<int>(std::ceil((to - from).norm() / (0.5 * voxel_m)));
      for (int i = 1; i < n; ++i) path.push_back(from + (to - from) * i / n);
    }
    path.push_back(to);
    previous = &keyframe;
  }
  return path;
}

Vertical VerticalWithSurfaces(const DenseMap& surfaces, const KeyframePoses& poses, const Vertical& of_map) {
  if (of_map.source != VerticalSource::kCameras) return of_map;
  std::vector<Eigen::Vector3d> normals;
  for (const Surface::Vertex& vertex : ExtractSurface(surfaces.Merge(poses, SE3())).vertices)
    normals.push_back(vertex.normal.cast<double>());
  return VerticalFromNormals(normals, of_map.up_w).value_or(of_map);
}

Products MakeProducts(const DenseMap& map, const KeyframePoses& poses, const Vertical& vertical,
                      const std::vector<Eigen::Vector3d>& path_w, double robot_height_m) {
  const SE3 T_level_w = LevelFrame(vertical);
  // Centres of voxels at odd halves, so that a cell of the grid and of OctoMap is a column of voxels.
  const SE3 T_volume_level(Eigen::Quaterniond::Identity(), Eigen::Vector3d::Constant(-0.5 * map.voxel_m()));
  Products products{T_level_w, vertical, false, 0.0, {}, map.Merge(poses, T_volume_level * T_level_w), {}, {}, {}};
  products.surface = ExtractSurface(products.volume);
  Move(T_volume_level.Inverse(), products.surface);
  const Floor floor(products.surface, map.voxel_m());
  for (const Eigen::Vector3d& p : path_w) products.path.push_back(T_level_w * p);
  const auto n_above = std::ranges::count_if(
      products.path, [&](const Eigen::Vector3d& p) { return p.z() > floor.HeightAt(p.x(), p.y()); });
  products.has_floor = floor.found() && 2 * n_above >= static_cast<std::ptrdiff_t>(products.path.size());
  products.floor_m = floor.HeightAt(0.0, 0.0);
  if (products.has_floor) {
    try {
      products.grid = MakeGrid(products.volume, floor, robot_height_m, products.path);
    } catch (const std::runtime_error& error) {
      products.no_grid = error.what();
    }
  }
  Move(T_level_w.Inverse(), products.surface);
  return products;
}

OccupancyGrid ToOccupancyGrid(const Products& products) {
  const GroundGrid& ground = products.grid;
  const auto cell_of = [&](double x_m) { return static_cast<int>(std::lround(x_m / ground.cell_m)); };
  OccupancyGrid grid{products.T_level_w.Inverse(), products.floor_m,  ground.cell_m,     cell_of(ground.origin_m.x()),
                     cell_of(ground.origin_m.y()), ground.cells.cols, ground.cells.rows, {}};
  if (!ground.cells.empty()) grid.cells.assign(ground.cells.datastart, ground.cells.dataend);
  return grid;
}

std::string ToPly(const Surface& surface, bool with_faces) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float "
      "z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar "
      "green\nproperty "
      "uchar blue\n",
      surface.vertices.size());
  if (with_faces) {
    bytes += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", surface.triangles.size());
  }
  bytes += "end_header\n";
  for (const Surface::Vertex& vertex : surface.vertices) {
    for (const float value : {vertex.p.x(), vertex.p.y(), vertex.p.z()}) AppendLittleEndian(value, bytes);
    for (const float value : {vertex.normal.x(), vertex.normal.y(), vertex.normal.z()})
      AppendLittleEndian(value, bytes);
    for (int channel = 0; channel < 3; ++channel) AppendLittleEndian(vertex.grey, bytes);
  }
  if (!with_faces) return bytes;
  for (const auto& triangle : surface.triangles) {
    AppendLittleEndian(uint8_t{3}, bytes);
    for (const uint32_t index : triangle) AppendLittleEndian(index, bytes);
  }
  return bytes;
}

std::string ToObj(const Surface& surface) {
  std::string text = "# surfaces; metres; v x y z r g b\no surface\n";
  const auto out = std::back_inserter(text);
  for (const Surface::Vertex& vertex : surface.vertices) {
    const double grey = vertex.grey / 255.0;
    fmt::format_to(out, "v {:.4f} {:.4f} {:.4f} {:.3f} {:.3f} {:.3f}\n", vertex.p.x(), vertex.p.y(), vertex.p.z(),
                   grey, grey, grey);
  }
  for (const Surface::Vertex& vertex : surface.vertices)
    fmt::format_to(out, "vn {:.3f} {:.3f} {:.3f}\n", vertex.normal.x(), vertex.normal.y(), vertex.normal.z());
  // Vertices and normals are numbered from 1.
  for (const auto& [a, b, c] : surface.triangles)
    fmt::format_to(out, "f {0}//{0} {1}//{1} {2}//{2}\n", a + 1, b + 1, c + 1);
  return text;
}

std::string ToPgm(const GroundGrid& grid) {
  std::string bytes = fmt::format("P5\n{} {}\n255\n", grid.cells.cols, grid.cells.rows);
  for (int y = grid.cells.rows - 1; y >= 0; --y) {
    bytes.append(grid.cells.ptr<char>(y), static_cast<size_t>(grid.cells.cols));
  }
  return bytes;
}

std::string ToMapYaml(const GroundGrid& grid, const std::string& image) {
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {:.17g}\norigin: [{:.17g}, {:.17g}, 0.0]\nnegate: 0\noccupied_thresh: "
      "0.65\nfree_thresh: 0.196\n",
      image, grid.cell_m, grid.origin_m.x(), grid.origin_m.y());
}

std::vector<std::string> WriteProducts(const std::filesystem::path& folder, const Products& products,
                                       ProductKind kind) {
  std::vector<std::string> names;
  const auto write = [&](const char* name, const std::string& bytes) {
    WriteFileAtomically((folder / name).string(), bytes);
    names.emplace_back(name);
  };
  switch (kind) {
    case ProductKind::kCloud:
      write(result_file::kCloud, ToPly(products.surface, false));
      break;
    case ProductKind::kMesh:
      write(result_file::kMesh, ToPly(products.surface, true));
      break;
    case ProductKind::kMeshObj:
      write(result_file::kMeshText, ToObj(products.surface));
      break;
    case ProductKind::kOctoMap: {
      octomap::OcTree tree = ToOctree(products.volume);
      std::ostringstream whole, binary;
      if (!tree.write(whole) || !tree.writeBinary(binary))
        throw std::runtime_error(std::string(result_file::kVoxels) + ": OctoMap cannot write the tree");
      write(result_file::kVoxels, whole.str());
      write(result_file::kOccupiedVoxels, binary.str());
      break;
    }
    case ProductKind::kGrid:
      if (products.has_floor && products.no_grid.empty()) {
        write(result_file::kGrid, ToPgm(products.grid));
        write(result_file::kGridMetadata, ToMapYaml(products.grid, result_file::kGrid));
        write(result_file::kDistances, EncodePng(TopDown(InMillimetres(products.grid.distance_m))));
        write(result_file::kHeights, EncodePng(TopDown(InMillimetres(products.grid.height_m))));
      }
      write(result_file::kPath, PathCsv(products.path));
      break;
  }
  return names;
}

void WriteFrames(const std::filesystem::path& folder, const Products& products) {
  WriteFileAtomically((folder / result_file::kSurfaceFrames).string(), FramesJson(products));
}

}  // namespace plslam::dense
