#include "core/features/orb_detector.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core/types.hpp>
#include <opencv2/features2d.hpp>

namespace plslam {
namespace {

constexpr int kFastRadius_px = 3;
/// Corners a cell of `SpreadCorners` is expected to give.
constexpr double kCornersPerCell = 2.0;

/// Corners with their centre in `area`.
void AppendCorners(const cv::Mat& image, const cv::Rect& area, int threshold, std::vector<cv::KeyPoint>& scratch,
                   std::vector<Corner>& corners) {
  const cv::Rect read(area.x - kFastRadius_px, area.y - kFastRadius_px, area.width + 2 * kFastRadius_px,
                      area.height + 2 * kFastRadius_px);
  scratch.clear();
  cv::FAST(image(read), scratch, threshold, true);
  for (const cv::KeyPoint& k : scratch) {
    corners.push_back({read.x + static_cast<int>(k.pt.x), read.y + static_cast<int>(k.pt.y), k.response});
  }
}

/// Which cells of the area hold a corner, row by row.
std::vector<char> OccupiedCells(const std::vector<Corner>& corners, const cv::Rect& area, int columns, int rows) {
  std::vector<char> occupied(static_cast<size_t>(columns) * rows, 0);
  for (const Corner& c : corners) {
    occupied[static_cast<size_t>((c.y - area.y) / kFastCell_px) * columns + (c.x - area.x) / kFastCell_px] = 1;
  }
  return occupied;
}

bool Better(const Corner& a, const Corner& b) {
  if (a.response != b.response) return a.response > b.response;
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

}  // namespace

std::vector<Corner> DetectCorners(const cv::Mat& image, int threshold, int low_threshold, int margin_px) {
  const int margin = std::max(margin_px, kFastRadius_px);
  const cv::Rect area(margin, margin, image.cols - 2 * margin, image.rows - 2 * margin);
  std::vector<Corner> corners;
  if (area.width <= 0 || area.height <= 0) return corners;
  std::vector<cv::KeyPoint> scratch;
  AppendCorners(image, area, threshold, scratch, corners);
  if (low_threshold >= threshold) return corners;

  const int columns = (area.width + kFastCell_px - 1) / kFastCell_px;
  const int rows = (area.height + kFastCell_px - 1) / kFastCell_px;
  const std::vector<char> occupied = OccupiedCells(corners, area, columns, rows);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      // Runs of empty cells are searched in one go.
      const int first = c;
      while (c < columns && occupied[static_cast<size_t>(r) * columns + c] == 0) ++c;
      if (c == first) continue;
      const cv::Rect run(area.x + first * kFastCell_px, area.y + r * kFastCell_px, (c - first) * kFastCell_px,
                         kFastCell_px);
      AppendCorners(image, run & area, low_threshold, scratch, corners);
    }
  }
  return corners;
}

std::vector<Corner> SpreadCorners(std::vector<Corner> corners, int quota, int width_px, int height_px) {
  if (quota <= 0) return {};
  if (static_cast<int>(corners.size()) <= quota) return corners;
  const double cell_px = std::max(4.0, std::sqrt(kCornersPerCell * width_px * height_px / quota));
  const int columns = static_cast<int>(width_px / cell_px) + 1;
  const int rows = static_cast<int>(height_px / cell_px) + 1;
  std::vector<std::vector<Corner>> cells(static_cast<size_t>(columns) * rows);
  for (const Corner& c : corners) {
    cells[static_cast<size_t>(c.y / cell_px) * columns + static_cast<size_t>(c.x / cell_px)].push_back(c);
  }
  for (std::vector<Corner>& cell : cells) std::sort(cell.begin(), cell.end(), Better);

  std::vector<Corner> kept;
  kept.reserve(quota);
  for (size_t turn = 0; static_cast<int>(kept.size()) < quota; ++turn) {
    std::vector<Corner> offered;
    for (const std::vector<Corner>& cell : cells) {
      if (turn < cell.size()) offered.push_back(cell[turn]);
    }
    if (offered.empty()) break;
    const size_t room = static_cast<size_t>(quota) - kept.size();
    if (offered.size() > room) {
      std::sort(offered.begin(), offered.end(), Better);
      offered.resize(room);
    }
    kept.insert(kept.end(), offered.begin(), offered.end());
  }
  return kept;
}

}  // namespace plslam
