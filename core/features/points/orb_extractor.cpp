// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/points/orb_extractor.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "core/features/points/orb_detector.h"

namespace plslam {
namespace {

/// The disc of the orientation, and one more column that its vector code reads.
constexpr int kDescriptorMargin_px = kOrbPatchRadius_px + 1;

/// Number of points of each level, in proportion to its side (not its area, so that coarse levels keep enough).
std::vector<int> LevelQuotas(const OrbOptions& options, int levels, int max_points) {
  std::vector<double> sides(levels, 1.0);
  for (int level = 1; level < levels; ++level) sides[level] = sides[level - 1] / options.scale_factor;
  const double sum = std::accumulate(sides.begin(), sides.end(), 0.0);
  std::vector<int> quotas;
  quotas.reserve(levels);
  for (const double side : sides) quotas.push_back(static_cast<int>(std::lround(max_points * side / sum)));
  return quotas;
}

bool IsAllowed(const cv::Mat& allowed, const Eigen::Vector2d& px) {
  const int u = std::clamp(static_cast<int>(std::lround(px.x())), 0, allowed.cols - 1);
  const int v = std::clamp(static_cast<int>(std::lround(px.y())), 0, allowed.rows - 1);
  return allowed.at<uint8_t>(v, u) != 0;
}

}  // namespace

std::vector<Corner> OrbExtractor::FindCorners(int level, int quota, const cv::Mat& allowed) {
  const cv::Mat& image = pyramid_.image(level);
  std::vector<Corner> corners =
      detector_.Detect(image, options_.fast_threshold, options_.min_fast_threshold, kDescriptorMargin_px);
  if (!allowed.empty()) {
    std::erase_if(corners, [&](const Corner& c) {
      return !IsAllowed(allowed, pyramid_.ToImage(Eigen::Vector2d(c.x, c.y), level));
    });
  }
  // Corner ratios are computed after a first, slightly larger selection: there may be ten times as many corners as
  // needed.
  corners = SpreadCorners(corners, quota + quota / 4, image.cols, image.rows);
  std::erase_if(corners, [&](const Corner& c) { return CornerRatio(image, c.x, c.y) < options_.min_corner_ratio; });
  return SpreadCorners(corners, quota, image.cols, image.rows);
}

std::vector<PointFeature> OrbExtractor::Extract(const cv::Mat& image, const cv::Mat& allowed,
                                                std::optional<int> maximum) {
  const int max_points = maximum.value_or(options_.max_points);
  if (image.empty()) return {};
  if (image.type() != CV_8UC1) throw std::invalid_argument("OrbExtractor: the image must be 8 bit grey");
  pyramid_.Build(image, options_.levels, options_.scale_factor);
  const std::vector<int> quotas = LevelQuotas(options_, pyramid_.levels(), max_points);
  descriptors_.resize(std::max(descriptors_.size(), static_cast<size_t>(pyramid_.levels())));
  std::vector<PointFeature> points;
  int unused = 0;
  for (int level = 0; level < pyramid_.levels(); ++level) {
    const cv::Mat& level_image = pyramid_.image(level);
    // Coarser levels may use what is left of a level's quota; the total never exceeds the maximum.
    const int room = max_points - static_cast<int>(points.size());
    const int quota = std::min(quotas[level] + unused, room);
    const std::vector<Corner> corners = FindCorners(level, quota, allowed);
    unused = quota - static_cast<int>(corners.size());
    if (corners.empty()) continue;
    BlurForBrief(level_image, blurred_);
    for (const Corner& c : corners) {
      PointFeature point;
      point.px = pyramid_.ToImage(detector_.SubPixel(c), level);
      point.response = static_cast<float>(c.response);
      point.octave = level;
      point.scale = pyramid_.scale(level).x();
      point.angle_rad = IntensityCentroidAngle(level_image, c.x, c.y);
      point.descriptor = descriptors_[level].Compute(blurred_, c.x, c.y, AngleBin(point.angle_rad));
      points.push_back(point);
    }
  }
  return points;
}

}  // namespace plslam
