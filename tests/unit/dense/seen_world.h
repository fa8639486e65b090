// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/datasets/synthetic/simulator.h"
#include "dense_process/dense_map.h"
#include "dense_process/surface.h"

namespace plslam::dense::test {

double Quantile(std::vector<double> values, double share);
/// Distances of points from the surfaces of a world.
std::vector<double> DistancesFrom(const synthetic::World& world, const std::vector<Eigen::Vector3d>& points);

/// Share of the places (10 cm) of a world's surfaces at which a measured surface has two layers more than `gap_m` apart
/// that face the same way: double walls.
double DoubledShare(const synthetic::World& world, const std::vector<Surface::Vertex>& vertices, double gap_m);

/// Surfaces of a built-in world, seen from the true poses of every `step`-th frame. The frame w is that of the world.
class SeenWorld {
 public:
  SeenWorld(const std::string& options, int step, double voxel_m);

  const synthetic::Simulator& simulator() const { return simulator_; }
  const DenseMap& map() const { return map_; }
  const KeyframePoses& poses() const { return poses_; }
  const Surface& surface() const { return surface_; }
  /// Errors of the depth of pixels, in their standard deviations.
  const std::vector<double>& normalised() const { return normalised_; }
  std::vector<Eigen::Vector3d> Path() const;

  /// Distances of the surface, up to `range_m` from the nearest keyframe, from the true one.
  std::vector<double> Errors(double range_m) const;
  /// Share of the true surface seen from less than `range_m` that is present within 1.5 voxels.
  double Completeness(double range_m) const;

 private:
  void CompareDepth(int frame, const DepthImage& depth);

  synthetic::Simulator simulator_;
  int step_;
  DenseMap map_;
  KeyframePoses poses_;
  Surface surface_;
  std::vector<double> normalised_;
};

}  // namespace plslam::dense::test
