// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/maps/map_ply.h"

#include <fmt/format.h>

#include <cstdint>

#include "core/io/files/little_endian.h"
#include "core/io/maps/map_colours.h"

namespace plslam {
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
