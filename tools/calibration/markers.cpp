// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/markers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/calibration/aruco.h"

namespace plslam::calibration {
namespace {

constexpr int kMinCorners = 8;
/// Markers in an image whose numbers may be misread.
constexpr size_t kMostMisread = 2;
/// Cells along the side of a marker with its border.
constexpr int kMarkerCells = 7;
constexpr int kTagBorder = 2;
constexpr int kTagCells = 6 + 2 * kTagBorder;

using aruco::FoundMarkers;

/// Moves corners of the board (by `BoardCorners` indices) onto the saddle points of the image, within windows of
/// `share` of the shortest square, 2 to 7 px.
void Refine(const Board& board, const cv::Mat& image, double share, BoardView* view) {
  double square_px = 100.0;
  for (size_t i = 1; i < view->corners.size(); ++i) {
    const bool neighbours =
        view->corners[i] == view->corners[i - 1] + 1 && view->corners[i] % board.CornerColumns() != 0;
    if (neighbours) square_px = std::min(square_px, (view->pixels[i] - view->pixels[i - 1]).norm());
  }
  const int window = std::clamp(static_cast<int>(share * square_px), 2, 7);
  std::vector<cv::Point2f> corners;
  for (const Eigen::Vector2d& p : view->pixels)
    corners.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  cv::cornerSubPix(image, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-4});
  for (size_t i = 0; i < corners.size(); ++i) view->pixels[i] = {corners[i].x, corners[i].y};
}

BoardView FindChess(const Board& board, const cv::Mat& image) {
  BoardView view;
  std::vector<cv::Point2f> corners;
  const int flags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  if (!cv::findChessboardCorners(image, {board.columns, board.rows}, corners, flags)) return view;
  for (size_t i = 0; i < corners.size(); ++i) {
    view.corners.push_back(static_cast<int>(i));
    view.pixels.emplace_back(corners[i].x, corners[i].y);
  }
  Refine(board, image, 0.4, &view);
  return view;
}

/// Returns whether markers contradict the board: some have higher numbers than it has, as on a board with more rows, or
/// most of their corners do not fit one homography, to `bound_m`.
bool Contradicts(const std::vector<std::vector<cv::Point3f>>& board, double bound_m, const FoundMarkers& read) {
  std::vector<cv::Point2f> on_board, seen;
  size_t n_unknown = 0;
  for (size_t i = 0; i < read.ids.size(); ++i) {
    if (read.ids[i] >= static_cast<int>(board.size())) {
      ++n_unknown;
      continue;
    }
    for (size_t k = 0; k < 4; ++k) {
      const cv::Point3f p = board[static_cast<size_t>(read.ids[i])][k];
      on_board.emplace_back(p.x, p.y);
      seen.push_back(read.corners[i][k]);
    }
  }
  if (n_unknown > kMostMisread || 2 * n_unknown > read.ids.size()) return true;
  if (on_board.size() < 16) return false;
  cv::Mat inliers;
  cv::findHomography(seen, on_board, inliers, cv::RANSAC, bound_m);
  return inliers.empty() || 2 * static_cast<size_t>(cv::countNonZero(inliers)) < on_board.size();
}

BoardView FindCharuco(const Board& board, const cv::Mat& image) {
  BoardView view;
  const aruco::CharucoLayout charuco = aruco::LayoutOf(board);
  const FoundMarkers read = aruco::DetectMarkers(image, aruco::Dictionary::kMarkers);
  if (read.ids.size() < 4) return view;
  view.contradicts = Contradicts(charuco.markers, 0.25 * board.square_m, read);
  if (view.contradicts) return view;
  const aruco::CharucoCorners found = aruco::InterpolateCorners(image, board, read);
  if (static_cast<int>(found.indices.size()) < kMinCorners) return view;
  for (size_t i = 0; i < found.indices.size(); ++i) {
    const cv::Point3f& at = charuco.corners[static_cast<size_t>(found.indices[i])];
    view.corners.push_back(static_cast<int>(std::lround(at.y / board.square_m) - 1) * board.CornerColumns() +
                           static_cast<int>(std::lround(at.x / board.square_m)) - 1);
    // OpenCV counts these from the upper left corner of the first pixel, unlike all else.
    view.pixels.emplace_back(found.pixels[i].x - 0.5, found.pixels[i].y - 0.5);
  }
  // The window must not reach the markers.
  Refine(board, image, 0.5 * (1.0 - board.marker_m / board.square_m), &view);
  return view;
}

/// The index in `BoardCorners` of corner `k` (clockwise from the upper left one) of tag `id`. Tags are numbered from
/// the lower left.
int CornerOfTag(const Board& board, int id, size_t k) {
  const int row = 2 * (board.rows - 1 - id / board.columns) + (k >= 2 ? 1 : 0);
  const int column = 2 * (id % board.columns) + (k == 1 || k == 2 ? 1 : 0);
  return row * board.CornerColumns() + column;
}

std::vector<std::vector<cv::Point3f>> TagCorners(const Board& board) {
  const std::vector<Eigen::Vector2d> corners = BoardCorners(board);
  std::vector<std::vector<cv::Point3f>> tags(static_cast<size_t>(board.columns * board.rows));
  for (size_t id = 0; id < tags.size(); ++id) {
    for (size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2f p =
          corners[static_cast<size_t>(CornerOfTag(board, static_cast<int>(id), k))].cast<float>();
      tags[id].emplace_back(p.x(), p.y(), 0.0F);
    }
  }
  return tags;
}

/// One look for tags, at an image that is `scale` times as large.
struct TagPass {
  int scale;
  aruco::Threshold threshold;
};
/// The squares at the corners touch the tags, and depending on the threshold merge with them: a tag that one pass
/// misses is found by another.
constexpr std::array kTagPasses = {TagPass{1, {10, 7.0}}, TagPass{2, {4, 7.0}}, TagPass{1, {10, 15.0}}};
constexpr int kLargestScaledSide_px = 1300;

/// Tags that `read` already has are skipped.
void ReadTags(const cv::Mat& image, const TagPass& pass, FoundMarkers* read) {
  cv::Mat scaled = image;
  if (pass.scale != 1) cv::resize(image, scaled, {}, pass.scale, pass.scale, cv::INTER_LINEAR);
  FoundMarkers found = aruco::DetectMarkers(scaled, aruco::Dictionary::kTags, kTagBorder, pass.threshold);
  const float to_image = 1.0F / static_cast<float>(pass.scale);
  for (size_t i = 0; i < found.ids.size(); ++i) {
    if (std::ranges::find(read->ids, found.ids[i]) != read->ids.end()) continue;
    for (cv::Point2f& p : found.corners[i]) p = (p + cv::Point2f(0.5F, 0.5F)) * to_image - cv::Point2f(0.5F, 0.5F);
    read->ids.push_back(found.ids[i]);
    read->corners.push_back(found.corners[i]);
  }
}

/// The first corner of a tag is a matter of convention: OpenCV's tags are rotated by 180 degrees. The other tags
/// decide. Returns false if no rotation fits.
bool TurnTags(const std::vector<std::vector<cv::Point3f>>& board, double bound_m, FoundMarkers* read) {
  for (const int turn : {2, 0, 1, 3}) {
    FoundMarkers turned = *read;
    for (auto& corners : turned.corners) std::rotate(corners.begin(), corners.begin() + turn, corners.end());
    if (Contradicts(board, bound_m, turned)) continue;
    *read = turned;
    return true;
  }
  return false;
}

/// Moves the corners of a tag onto the saddle points between its border and the squares at its corners. Returns false
/// if they are not near.
bool RefineTag(const Board& board, const cv::Mat& image, std::vector<cv::Point2f>* tag) {
  double side_px = 1e9;
  for (size_t k = 0; k < 4; ++k) side_px = std::min(side_px, cv::norm((*tag)[k] - (*tag)[(k + 1) % 4]));
  // The window must reach neither the end of the square nor the cells within the border.
  const double free = std::min(board.spacing, static_cast<double>(kTagBorder) / kTagCells);
  const int window = std::clamp(static_cast<int>(0.7 * free * side_px), 2, 7);
  const std::vector<cv::Point2f> before = *tag;
  cv::cornerSubPix(image, *tag, {window, window}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-4});
  for (size_t k = 0; k < 4; ++k) {
    if (cv::norm((*tag)[k] - before[k]) > std::min(0.1 * side_px + 2.0, 5.0)) return false;
  }
  return true;
}

BoardView FindAprilgrid(const Board& board, const cv::Mat& image) {
  BoardView view;
  FoundMarkers read;
  for (const TagPass& pass : kTagPasses) {
    if (static_cast<int>(read.ids.size()) >= board.columns * board.rows) break;
    if (pass.scale == 1 || std::max(image.cols, image.rows) <= kLargestScaledSide_px) ReadTags(image, pass, &read);
  }
  // The orientation of fewer markers is ambiguous.
  if (read.ids.size() < 4) return view;
  const auto n_known = std::ranges::count_if(read.ids, [&](int id) { return id < board.columns * board.rows; });
  if (n_known < 4) {
    view.contradicts = 2 * static_cast<size_t>(n_known) < read.ids.size();
    return view;
  }
  view.contradicts = !TurnTags(TagCorners(board), 0.25 * board.marker_m, &read);
  if (view.contradicts) return view;
  std::map<int, Eigen::Vector2d> corners;
  for (size_t i = 0; i < read.ids.size(); ++i) {
    if (read.ids[i] >= board.columns * board.rows || !RefineTag(board, image, &read.corners[i])) continue;
    for (size_t k = 0; k < 4; ++k) {
      const cv::Point2f& p = read.corners[i][k];
      corners[CornerOfTag(board, read.ids[i], k)] = {p.x, p.y};
    }
  }
  if (static_cast<int>(corners.size()) < kMinCorners) return view;
  for (const auto& [index, pixel] : corners) {
    view.corners.push_back(index);
    view.pixels.push_back(pixel);
  }
  return view;
}

Marker DrawnMarker(aruco::Dictionary dictionary, int id, int cells, int border) {
  const cv::Mat picture = aruco::DrawMarker(dictionary, id, cells, border);
  Marker marker;
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) marker.black.push_back(picture.at<uchar>(y, x) == 0);
  }
  return marker;
}

}  // namespace

std::vector<Marker> MarkersOf(const Board& board) {
  std::vector<Marker> markers;
  if (board.kind == Board::Kind::kAprilgrid) {
    for (const std::vector<cv::Point3f>& tag : TagCorners(board)) {
      markers.push_back(
          DrawnMarker(aruco::Dictionary::kTags, static_cast<int>(markers.size()), kTagCells, kTagBorder));
      std::reverse(markers.back().black.begin(), markers.back().black.end());
      markers.back().upper_left_m = {tag[0].x, tag[0].y};
    }
  }
  if (board.kind != Board::Kind::kCharuco) return markers;
  const aruco::CharucoLayout charuco = aruco::LayoutOf(board);
  for (size_t i = 0; i < charuco.markers.size(); ++i) {
    markers.push_back(DrawnMarker(aruco::Dictionary::kMarkers, charuco.ids[i], kMarkerCells, 1));
    markers.back().upper_left_m = {charuco.markers[i][0].x, charuco.markers[i][0].y};
  }
  return markers;
}

BoardView FindBoard(const Board& board, const cv::Mat& image) {
  switch (board.kind) {
    case Board::Kind::kChess:
      return FindChess(board, image);
    case Board::Kind::kCharuco:
      return FindCharuco(board, image);
    default:
      return FindAprilgrid(board, image);
  }
}

}  // namespace plslam::calibration
