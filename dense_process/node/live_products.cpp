// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/node/live_products.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "core/bus/run_loop.h"
#include "core/errors/log.h"

namespace plslam::dense {
namespace {

constexpr double kLeastInterval_ms = 2000.0;
// Cosine of the angle of two verticals that are the same for the published grid: 0.3 degrees.
constexpr double kSameVertical = 1.0 - 1.4e-5;

}  // namespace

double LiveProducts::Publish(const DenseMap& surfaces, const Map& map, double began_ms) {
  is_old_ = false;
  try {
    const KeyframePoses poses = PosesOf(map);
    const Vertical vertical = VerticalWithSurfaces(surfaces, poses, VerticalOf(map, up_c_));
    if (!vertical_ || vertical.up_w.dot(vertical_->up_w) < kSameVertical) vertical_ = vertical;
    const Products products =
        MakeProducts(surfaces, poses, *vertical_, PathOf(poses, surfaces.voxel_m()), robot_height_m_);
    SendGrid(products);
    submaps_.Publish(surfaces.Split(products.surface, poses), bus::SubmapPublisher::Changes::kSurfaces);
  } catch (const std::exception& error) {
    LogWarning("grid and surfaces are not published: {}", error.what());
  }
  const double took_ms = bus::NowMs() - began_ms;
  next_ms_ = began_ms + std::max(kLeastInterval_ms, 10.0 * took_ms);
  return took_ms;
}

void LiveProducts::PublishFinal(const Products& products, const SurfaceCloud& cloud) {
  SendGrid(products);
  submaps_.Publish(cloud, bus::SubmapPublisher::Changes::kAll);
  is_old_ = false;
}

void LiveProducts::SendGrid(const Products& products) {
  if (!products.no_grid.empty() && !std::exchange(has_no_grid_, true)) {
    LogWarning("the grid on the bus is that of before: {}", products.no_grid);
  }
  if (products.has_floor && products.no_grid.empty()) grid_.Publish(ToOccupancyGrid(products));
}

}  // namespace plslam::dense
