// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/surface.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>

namespace plslam::dense {
namespace {

struct IndexHash {
  size_t operator()(const Eigen::Vector3i& i) const {
    const auto mix = [](int value, size_t factor) {
      return static_cast<size_t>(static_cast<uint32_t>(value)) * factor;
    };
    return mix(i.x(), 73856093) ^ mix(i.y(), 19349663) ^ mix(i.z(), 83492791);
  }
};
using CubeIndex = std::unordered_map<Eigen::Vector3i, uint32_t, IndexHash>;

Eigen::Vector3i Corner(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2 & 1}; }

/// The vertex of the cube whose first corner is `base`; nullopt without a crossing, or next to unknown voxels.
std::optional<Surface::Vertex> VertexOf(const Volume& volume, const Volume::Reader& reader,
                                        const Eigen::Vector3i& base) {
  std::array<float, 8> distance{};
  float grey = 0.0F;
  float weight = 0.0F;
  int n_behind = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const std::optional<Volume::Voxel> voxel = reader.At(base + Corner(corner));
    if (!voxel || voxel->weight < kLeastKnown) return std::nullopt;
    distance[corner] = voxel->distance_m;
    n_behind += voxel->distance_m < 0.0F ? 1 : 0;
    // The voxel nearest to the surface has its grey value.
    const float w = 1.0F / (std::abs(voxel->distance_m) + 0.1F * static_cast<float>(volume.voxel_m()));
    grey += w * voxel->grey;
    weight += w;
  }
  if (n_behind == 0 || n_behind == 8) return std::nullopt;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  int n_crossings = 0;
  for (int a = 0; a < 8; ++a) {
    for (int axis = 0; axis < 3; ++axis) {
      const int b = a | 1 << axis;
      if (b == a || (distance[a] < 0.0F) == (distance[b] < 0.0F)) continue;
      const float t = distance[a] / (distance[a] - distance[b]);
      sum += Corner(a).cast<float>() + t * Eigen::Vector3f::Unit(axis);
      ++n_crossings;
    }
  }
  Eigen::Vector3f gradient = Eigen::Vector3f::Zero();
  for (int a = 0; a < 8; ++a) {
    for (int axis = 0; axis < 3; ++axis) gradient[axis] += (a >> axis & 1) != 0 ? distance[a] : -distance[a];
  }
  if (gradient.norm() < 1e-9F) return std::nullopt;
  Surface::Vertex vertex;
  vertex.p = static_cast<float>(volume.voxel_m()) * (base.cast<float>() + sum / static_cast<float>(n_crossings));
  vertex.normal = gradient.normalized();
  vertex.grey = static_cast<uint8_t>(std::lround(std::clamp(grey / weight, 0.0F, 255.0F)));
  return vertex;
}

}  // namespace

Surface ExtractSurface(const Volume& volume) {
  const Volume::Reader reader(volume);
  Surface surface;
  CubeIndex index_of;
  std::vector<Eigen::Vector3i> cubes;
  volume.Visit([&](const Volume::Voxel& voxel) {
    // A crossing is within one truncation, where distances are not clipped.
    if (voxel.weight < kLeastKnown || std::abs(voxel.distance_m) > 2.0 * volume.voxel_m()) return;
    if (const std::optional<Surface::Vertex> vertex = VertexOf(volume, reader, voxel.index)) {
      index_of.emplace(voxel.index, static_cast<uint32_t>(surface.vertices.size()));
      cubes.push_back(voxel.index);
      surface.vertices.push_back(*vertex);
    }
  });
  // An edge of the grid that crosses the surface is shared by four cubes, whose vertices are a quadrilateral.
  for (const Eigen::Vector3i& cube : cubes) {
    const bool behind = reader.At(cube)->distance_m < 0.0F;
    for (int axis = 0; axis < 3; ++axis) {
      if ((reader.At(cube + Eigen::Vector3i::Unit(axis))->distance_m < 0.0F) == behind) continue;
      const Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + 1) % 3);
      const Eigen::Vector3i v = Eigen::Vector3i::Unit((axis + 2) % 3);
      std::array<uint32_t, 4> corners{};
      const std::array<Eigen::Vector3i, 4> around{cube, cube - u, cube - u - v, cube - v};
      bool complete = true;
      for (size_t i = 0; i < around.size(); ++i) {
        const auto found = index_of.find(around[i]);
        complete = complete && found != index_of.end();
        if (complete) corners[i] = found->second;
      }
      if (!complete) continue;
      // Counter-clockwise, seen from free space.
      if (!behind) std::swap(corners[1], corners[3]);
      surface.triangles.push_back({corners[0], corners[1], corners[2]});
      surface.triangles.push_back({corners[0], corners[2], corners[3]});
    }
  }
  return surface;
}

void Move(const SE3& T_a_surface, Surface& surface) {
  const Eigen::Matrix3f R = T_a_surface.R().cast<float>();
  for (Surface::Vertex& vertex : surface.vertices) {
    vertex.p = (T_a_surface * vertex.p.cast<double>()).cast<float>();
    vertex.normal = R * vertex.normal;
  }
}

}  // namespace plslam::dense
