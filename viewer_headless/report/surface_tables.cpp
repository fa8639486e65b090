// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/surface_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include <opencv2/imgproc.hpp>

#include "core/io/images/png_codec.h"

namespace plslam::viewer {
namespace {

constexpr double kCoarser = 1.15;  // ratio of the sides of the cubes of two attempts
constexpr double kSteps = 65535.0;
constexpr int kZeroNormal = 128;

struct Sum {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  double grey = 0.0;
  int n = 0;
};

/// The direction, of six, that is nearest to a normal.
int SideOf(const SurfacePoint& point) {
  int side = 0, most = -1;
  for (int i = 0; i < 3; ++i) {
    const int length = std::abs(int{point.normal[i]});
    if (length > most) {
      most = length;
      side = 2 * i + (point.normal[i] < 0 ? 1 : 0);
    }
  }
  return side;
}

uint64_t KeyOf(const SurfacePoint& point, double cube_m) {
  auto key = static_cast<uint64_t>(SideOf(point));
  for (int i = 0; i < 3; ++i) {
    key = key << 20 | (static_cast<uint64_t>(static_cast<int64_t>(std::floor(point.p[i] / cube_m))) & 0xFFFFF);
  }
  return key;
}

std::vector<SurfacePoint> MeansIn(const std::vector<SurfacePoint>& points, double cube_m) {
  std::vector<Sum> sums;
  std::unordered_map<uint64_t, size_t> index_of;
  for (const SurfacePoint& point : points) {
    const size_t index = index_of.try_emplace(KeyOf(point, cube_m), sums.size()).first->second;
    if (index == sums.size()) sums.emplace_back();
    Sum& sum = sums[index];
    sum.p += point.p.cast<double>();
    sum.normal += UnitNormal(point);
    sum.grey += point.grey;
    ++sum.n;
  }
  std::vector<SurfacePoint> means;
  means.reserve(sums.size());
  for (const Sum& sum : sums) {
    means.push_back({(sum.p / sum.n).cast<float>(), RoundedNormal(sum.normal.normalized()),
                     static_cast<uint8_t>(std::lround(sum.grey / sum.n))});
  }
  return means;
}

/// The part of the grid with known cells, in which a pixel covers `side` x `side` cells: an occupied one counts most, a
/// free one more than unknown ones. Row 0 has the largest y.
cv::Mat PictureOf(const OccupancyGrid& grid, const cv::Rect& known, int side) {
  cv::Mat picture((known.height + side - 1) / side, (known.width + side - 1) / side, CV_8UC1,
                  cv::Scalar(OccupancyGrid::kUnknown));
  for (int y = 0; y < known.height; ++y) {
    for (int x = 0; x < known.width; ++x) {
      const uint8_t cell = grid.At(grid.first_column + known.x + x, grid.first_row + known.y + y);
      uint8_t& pixel = picture.at<uint8_t>(picture.rows - 1 - y / side, x / side);
      if (cell == OccupancyGrid::kOccupied || pixel == OccupancyGrid::kUnknown) pixel = cell;
    }
  }
  return picture;
}

std::optional<ReportGrid> ToReport(const OccupancyGrid& grid, int most_px) {
  if (grid.cells.empty()) return std::nullopt;
  const cv::Mat cells(grid.n_rows, grid.n_columns, CV_8UC1, const_cast<uint8_t*>(grid.cells.data()));
  const cv::Rect known = cv::boundingRect(cells != OccupancyGrid::kUnknown);
  if (known.empty()) return std::nullopt;
  const int side = (std::max(known.width, known.height) + most_px - 1) / most_px;
  const cv::Mat picture = PictureOf(grid, known, side);
  ReportGrid report;
  report.png = EncodePng(picture);
  report.pixel_m = grid.cell_m * side;
  report.width_px = picture.cols;
  report.height_px = picture.rows;
  report.corner_level = {grid.cell_m * (grid.first_column + known.x), grid.cell_m * (grid.first_row + known.y),
                         grid.floor_m};
  report.T_w_level = grid.T_w_level;
  return report;
}

}  // namespace

ThinnedCloud Thin(std::vector<SurfacePoint> points, double spacing_m, size_t most) {
  double cube_m = spacing_m;
  std::vector<SurfacePoint> thinned = std::move(points);
  while (thinned.size() > std::max<size_t>(most, 1)) {
    cube_m *= std::max(kCoarser, std::sqrt(0.8 * static_cast<double>(thinned.size()) / static_cast<double>(most)));
    thinned = MeansIn(thinned, cube_m);
  }
  return {cube_m, std::move(thinned)};
}

ReportSurfaces SurfaceTables(const SurfaceCloud& cloud, const OccupancyGrid& grid, const SurfaceLimits& limits) {
  ReportSurfaces surfaces;
  surfaces.grid = ToReport(grid, limits.grid_px);
  const ThinnedCloud thinned = Thin(cloud.PointsInW(), cloud.voxel_m, limits.points);
  surfaces.spacing_m = thinned.spacing_m;
  if (thinned.points.empty()) return surfaces;
  Eigen::Vector3f low = thinned.points.front().p, high = low;
  for (const SurfacePoint& point : thinned.points) {
    low = low.cwiseMin(point.p);
    high = high.cwiseMax(point.p);
  }
  surfaces.low_w = low.cast<double>();
  surfaces.step_m = std::max(1e-6, (high - low).cast<double>().maxCoeff() / kSteps);
  std::vector<uint16_t> p;
  std::vector<uint8_t> normals, greys;
  for (const SurfacePoint& point : thinned.points) {
    for (int i = 0; i < 3; ++i) {
      const double steps = (static_cast<double>(point.p[i]) - surfaces.low_w[i]) / surfaces.step_m;
      p.push_back(static_cast<uint16_t>(std::lround(std::clamp(steps, 0.0, kSteps))));
      normals.push_back(static_cast<uint8_t>(kZeroNormal + point.normal[i]));
    }
    greys.push_back(point.grey);
  }
  surfaces.points = {{"p", 3, std::move(p)}, {"normal", 3, std::move(normals)}, {"grey", 1, std::move(greys)}};
  return surfaces;
}

}  // namespace plslam::viewer
