// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/depth_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "core/geometry/hypot.h"

namespace plslam::vo {
namespace {

constexpr int kMinKnown = 5;
/// Spread of a window, in standard deviations of the sensor, above which it contains two surfaces; and a floor relative
/// to the depth for slanted surfaces.
constexpr double kMaxSpreadSigmas = 6.0;
constexpr double kMaxSpreadShare = 0.02;

/// Known depths in the 3x3 window around a pixel, ascending, in metres; padded with infinity.
struct Window {
  std::array<double, 9> depths_m{};
  int count = 0;
};

Window ReadWindow(const cv::Mat& depth16, int u, int v, double units_per_m) {
  Window w;
  w.depths_m.fill(std::numeric_limits<double>::infinity());
  for (int y = std::max(v - 1, 0); y <= std::min(v + 1, depth16.rows - 1); ++y) {
    for (int x = std::max(u - 1, 0); x <= std::min(u + 1, depth16.cols - 1); ++x) {
      const uint16_t units = depth16.at<uint16_t>(y, x);
      if (units > 0) w.depths_m[w.count++] = units / units_per_m;
    }
  }
  std::sort(w.depths_m.begin(), w.depths_m.end());
  return w;
}

std::optional<double> RobustDepth(const Window& w, double noise_per_m) {
  if (w.count < kMinKnown) return std::nullopt;
  const double z = w.depths_m[w.count / 2];
  const double spread = w.depths_m[w.count - 1] - w.depths_m[0];
  if (spread > std::max(kMaxSpreadSigmas * noise_per_m * z * z, kMaxSpreadShare * z)) return std::nullopt;
  return z;
}

}  // namespace

void AttachDepthToPoints(std::vector<StereoPoint>& points, const cv::Mat& depth16, double depth_units_per_m,
                         const StereoCamera& camera, const StereoOptions& options) {
  if (!(depth_units_per_m > 0.0)) throw std::invalid_argument("AttachDepth: the depth unit must be positive");
  if (depth16.empty()) return;
  if (depth16.type() != CV_16UC1) throw std::invalid_argument("AttachDepth: the depth map must have 16 bits");
  const double fb = camera.FocalBaseline();
  const double rounding_m = 1.0 / (depth_units_per_m * std::sqrt(12.0));
  for (StereoPoint& p : points) {
    const Eigen::Vector2d px = p.left.px;
    if (!(px.x() > -0.5 && px.y() > -0.5 && px.x() < depth16.cols - 0.5 && px.y() < depth16.rows - 0.5)) continue;
    const Window window = ReadWindow(depth16, static_cast<int>(std::lround(px.x())),
                                     static_cast<int>(std::lround(px.y())), depth_units_per_m);
    const std::optional<double> z = RobustDepth(window, options.depth_noise_per_m);
    if (!z) continue;
    const double disparity_px = fb / *z;
    if (disparity_px < options.min_disparity_px || disparity_px > options.max_disparity_px) continue;
    const double sigma_z_m = Hypot(options.depth_noise_per_m * *z * *z, rounding_m);
    p.disparity_px = disparity_px;
    p.sigma_disparity_px = fb / (*z * *z) * sigma_z_m;
  }
}

}  // namespace plslam::vo
