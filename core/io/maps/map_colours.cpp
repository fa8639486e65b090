// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/maps/map_colours.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/map/vertical.h"

namespace plslam {
namespace {

constexpr int kOldObservations = 20;
constexpr double kLowShare = 0.02;
constexpr double kHighShare = 0.98;

uint8_t Channel(double share) { return static_cast<uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0))); }

/// From blue (0) over green and yellow to red (1).
Colour Rainbow(double share) {
  const double hue = 4.0 * std::clamp(share, 0.0, 1.0);
  return {Channel(2.0 - std::abs(hue - 4.0)), Channel(2.0 - std::abs(hue - 2.0)), Channel(2.0 - std::abs(hue))};
}

}  // namespace

HeightColours::HeightColours(const Map& map) : up_w_(VerticalOf(map).up_w) {
  std::vector<double> heights;
  for (const auto& [id, point] : map.points()) heights.push_back(HeightOf(point.p_w));
  std::sort(heights.begin(), heights.end());
  if (heights.empty()) return;
  const auto at = [&](double share) {
    return heights[static_cast<size_t>(share * static_cast<double>(heights.size() - 1))];
  };
  low_ = at(kLowShare);
  high_ = at(kHighShare);
}

Colour HeightColours::operator()(const Eigen::Vector3d& p_w) const {
  return Rainbow(high_ > low_ ? (HeightOf(p_w) - low_) / (high_ - low_) : 0.5);
}

/// As in the pictures of the tracked features.
Colour ObservationsColour(size_t observations) {
  const double share = std::min(1.0, static_cast<double>(observations) / kOldObservations);
  return {Channel(1.0 - share * 100.0 / 255.0), Channel((70.0 + 185.0 * share) / 255.0), Channel(1.0 - share)};
}

}  // namespace plslam
