// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/level_frame.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <optional>
#include <vector>

namespace plslam::dense {
namespace {

constexpr double kTile = 40.0;       // edge of a tile, in voxels
constexpr float kHorizontal = 0.9F;  // least z of the normal
// A layer is large with this share of the largest one.
constexpr double kLargeShare = 1.0 / 3.0;
// Horizontal surface in a tile that counts, in voxels.
constexpr int kLeastInTile = 25;
// Largest difference between neighbours, as a share of the tile: a slope of 25 %.
constexpr double kSteepest = 0.25;

/// Numbers of horizontal surface elements by height, in voxels.
using Layers = std::map<int, int>;

int CountNear(const Layers& layers, int height) {
  int count = 0;
  for (int h = height - 1; h <= height + 1; ++h) {
    const auto found = layers.find(h);
    if (found != layers.end()) count += found->second;
  }
  return count;
}

/// The lowest large layer within the range; nullopt if there is little of any.
std::optional<int> LowestLarge(const Layers& layers, int from, int to) {
  int most = 0;
  for (const auto& [height, count] : layers) {
    if (height >= from && height <= to) most = std::max(most, CountNear(layers, height));
  }
  if (most < kLeastInTile) return std::nullopt;
  for (const auto& [height, count] : layers) {
    if (height < from || height > to || CountNear(layers, height) < kLargeShare * most) continue;
    // The peak of this layer.
    return CountNear(layers, height + 1) > CountNear(layers, height) && height < to ? height + 1 : height;
  }
  return std::nullopt;
}

double MeanNear(const Layers& layers, int height) {
  double sum = 0.0;
  int count = 0;
  for (int h = height - 1; h <= height + 1; ++h) {
    const auto found = layers.find(h);
    if (found == layers.end()) continue;
    sum += h * found->second;
    count += found->second;
  }
  return sum / count;
}

}  // namespace

SE3 LevelFrame(const Vertical& vertical) {
  const Eigen::Vector3d z = vertical.up_w.normalized();
  Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ() - z.z() * z;
  // A camera that looks straight down or up has its image's upper edge ahead.
  if (ahead.norm() < 0.1) ahead = -Eigen::Vector3d::UnitY() + z.y() * z;
  const Eigen::Vector3d x = ahead.normalized();
  Eigen::Matrix3d R_level_w;
  R_level_w << x.transpose(), z.cross(x).transpose(), z.transpose();
  return {R_level_w, Eigen::Vector3d::Zero()};
}

Floor::Tile Floor::TileAt(double x_m, double y_m) const {
  return {static_cast<int>(std::floor(x_m / tile_m_)), static_cast<int>(std::floor(y_m / tile_m_))};
}

Floor::Floor(const Surface& surface, double voxel_m) : tile_m_(kTile * voxel_m) {
  std::map<Tile, Layers> layers_of;
  std::map<Tile, int> size_of;
  Layers all;
  for (const Surface::Vertex& vertex : surface.vertices) {
    if (vertex.normal.z() < kHorizontal) continue;
    const Tile tile = TileAt(vertex.p.x(), vertex.p.y());
    const int height = static_cast<int>(std::lround(vertex.p.z() / voxel_m));
    ++layers_of[tile][height];
    ++size_of[tile];
    ++all[height];
  }
  if (all.empty()) return;
  // Begins with the tile that has most of the layer.
  const int lowest = all.begin()->first;
  const int highest = all.rbegin()->first;
  std::optional<std::pair<Tile, int>> first;
  int most = 0;
  for (const auto& [tile, layers] : layers_of) {
    const std::optional<int> height = LowestLarge(layers, lowest, highest);
    if (!height || CountNear(layers, *height) <= most) continue;
    most = CountNear(layers, *height);
    first = {tile, *height};
  }
  if (!first) return;
  const int step = static_cast<int>(kSteepest * kTile);
  std::map<Tile, int> level_of{{first->first, first->second}};
  std::deque<Tile> border{first->first};
  while (!border.empty()) {
    const Tile tile = border.front();
    border.pop_front();
    const int level = level_of.at(tile);
    for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(-1, 0), std::pair(0, 1), std::pair(0, -1)}) {
      const Tile next{tile.first + dx, tile.second + dy};
      const auto layers = layers_of.find(next);
      if (layers == layers_of.end() || level_of.contains(next)) continue;
      const std::optional<int> own = LowestLarge(layers->second, level - step, level + step);
      level_of[next] = own.value_or(level);
      border.push_back(next);
    }
  }
  for (const auto& [tile, level] : level_of) {
    const Layers& layers = layers_of.at(tile);
    const bool has = CountNear(layers, level) > 0;
    height_of_[tile] = voxel_m * (has ? MeanNear(layers, level) : static_cast<double>(level));
  }
}

double Floor::HeightAt(double x_m, double y_m) const {
  if (height_of_.empty()) return 0.0;
  const Tile at = TileAt(x_m, y_m);
  const auto own = height_of_.find(at);
  if (own != height_of_.end()) return own->second;
  const auto distance = [&](const auto& tile) {
    return std::abs(tile.first.first - at.first) + std::abs(tile.first.second - at.second);
  };
  return std::ranges::min_element(height_of_, {}, distance)->second;
}

}  // namespace plslam::dense
