// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/maps/map_ply.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <fmt/format.h>

#include "core/files/bytes.h"
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

namespace {

void AppendVertex(const Eigen::Vector3d& p_w, const Colour& colour, size_t observations, std::string& bytes) {
  for (const double value : p_w) AppendLittleEndian(static_cast<float>(value), bytes);
  for (const uint8_t channel : colour) AppendLittleEndian(channel, bytes);
  AppendLittleEndian(static_cast<int32_t>(observations), bytes);
}

}  // namespace

std::string MapPly(const Map& map) {
  const size_t n_points = map.points().size(), n_lines = map.lines().size();
  std::string ply = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment points, then both ends of each line; metres\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int observations\n"
      "element edge {}\nproperty int vertex1\nproperty int vertex2\nend_header\n",
      n_points + 2 * n_lines, n_lines);
  const HeightColours colour_of(map);
  for (const auto& [id, point] : map.points()) {
    AppendVertex(point.p_w, colour_of(point.p_w), point.observations.size(), ply);
  }
  for (const auto& [id, line] : map.lines()) {
    const Colour colour = ObservationsColour(line.observations.size());
    AppendVertex(line.segment_w.p, colour, line.observations.size(), ply);
    AppendVertex(line.segment_w.q, colour, line.observations.size(), ply);
  }
  for (size_t i = 0; i < n_lines; ++i) {
    AppendLittleEndian(static_cast<int32_t>(n_points + 2 * i), ply);
    AppendLittleEndian(static_cast<int32_t>(n_points + 2 * i + 1), ply);
  }
  return ply;
}

}  // namespace plslam
