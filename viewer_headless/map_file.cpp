#include "viewer_headless/map_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace plslam {
namespace {

using Colour = std::array<uint8_t, 3>;

constexpr int kOldSights = 20;
/// Heights beyond these shares of the points are drawn like those at them: outliers must not take all the colours.
constexpr double kLowShare = 0.02;
constexpr double kHighShare = 0.98;

uint8_t Channel(double share) { return static_cast<uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0))); }

/// From blue (0) over green and yellow to red (1).
Colour Rainbow(double share) {
  const double hue = 4.0 * std::clamp(share, 0.0, 1.0);
  return {Channel(2.0 - std::abs(hue - 4.0)), Channel(2.0 - std::abs(hue - 2.0)), Channel(2.0 - std::abs(hue))};
}

/// As in the pictures of the tracked features.
Colour AgeColour(size_t sights) {
  const double share = std::min(1.0, static_cast<double>(sights) / kOldSights);
  return {Channel(1.0 - share * 100.0 / 255.0), Channel((70.0 + 185.0 * share) / 255.0), Channel(1.0 - share)};
}

class Heights {
 public:
  explicit Heights(const Map& map) {
    std::vector<double> heights;
    for (const auto& [id, point] : map.points()) heights.push_back(-point.p_w.y());
    std::sort(heights.begin(), heights.end());
    if (heights.empty()) return;
    const auto at = [&](double share) {
      return heights[static_cast<size_t>(share * static_cast<double>(heights.size() - 1))];
    };
    low_ = at(kLowShare);
    high_ = at(kHighShare);
  }

  Colour ColourOf(const Eigen::Vector3d& p_w) const {
    return Rainbow(high_ > low_ ? (-p_w.y() - low_) / (high_ - low_) : 0.5);
  }

 private:
  double low_ = 0.0;
  double high_ = 0.0;
};

template <class Number>
void Append(Number number, std::string& bytes) {
  static_assert(std::endian::native == std::endian::little, "the file says little endian");
  char raw[sizeof(Number)];
  std::memcpy(raw, &number, sizeof(Number));
  bytes.append(raw, sizeof(Number));
}

void AppendVertex(const Eigen::Vector3d& p_w, const Colour& colour, size_t sights, std::string& bytes) {
  for (const double value : p_w) Append(static_cast<float>(value), bytes);
  for (const uint8_t channel : colour) Append(channel, bytes);
  Append(static_cast<int32_t>(sights), bytes);
}

}  // namespace

std::string MapPly(const Map& map) {
  const size_t n_points = map.points().size(), n_lines = map.lines().size();
  std::string ply = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment points, then both ends of each line; metres\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int sights\n"
      "element edge {}\nproperty int vertex1\nproperty int vertex2\nend_header\n",
      n_points + 2 * n_lines, n_lines);
  const Heights heights(map);
  for (const auto& [id, point] : map.points()) {
    AppendVertex(point.p_w, heights.ColourOf(point.p_w), point.sights.size(), ply);
  }
  for (const auto& [id, line] : map.lines()) {
    const Colour colour = AgeColour(line.sights.size());
    AppendVertex(line.segment_w.p, colour, line.sights.size(), ply);
    AppendVertex(line.segment_w.q, colour, line.sights.size(), ply);
  }
  for (size_t i = 0; i < n_lines; ++i) {
    Append(static_cast<int32_t>(n_points + 2 * i), ply);
    Append(static_cast<int32_t>(n_points + 2 * i + 1), ply);
  }
  return ply;
}

}  // namespace plslam
