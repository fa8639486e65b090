// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/markers.h"

#include <algorithm>
#include <cmath>

#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace plslam::calibration {
namespace {

constexpr int kMinCorners = 8;

cv::Ptr<cv::aruco::CharucoBoard> OpenCvBoard(const Board& board) {
  return cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square_m),
                                         static_cast<float>(board.marker_m),
                                         cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_250));
}

/// OpenCV 4.6 counts y of a board from below, later versions from above.
bool IsUpwards(const cv::aruco::CharucoBoard& board) {
  return board.objPoints.front()[0].y > board.objPoints.front()[3].y;
}

Eigen::Vector2d Downwards(const Board& board, bool upwards, const cv::Point3f& p) {
  const double x = p.x, y = p.y;
  return {x, upwards ? board.SquareRows() * board.square_m - y : y};
}

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

/// Whether markers lie as on the board: most of their corners fit one homography, to a quarter of a square.
bool Contradicts(const cv::aruco::CharucoBoard& board, const std::vector<std::vector<cv::Point2f>>& corners,
                 const std::vector<int>& ids) {
  std::vector<cv::Point2f> on_board, seen;
  size_t n_unknown = 0;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] >= static_cast<int>(board.objPoints.size())) {
      ++n_unknown;
      continue;
    }
    for (size_t k = 0; k < 4; ++k) {
      const cv::Point3f p = board.objPoints[static_cast<size_t>(ids[i])][k];
      on_board.emplace_back(p.x, p.y);
      seen.push_back(corners[i][k]);
    }
  }
  if (2 * n_unknown > ids.size()) return true;
  if (on_board.size() < 16) return false;
  cv::Mat inliers;
  cv::findHomography(seen, on_board, inliers, cv::RANSAC, 0.25 * board.getSquareLength());
  return inliers.empty() || 2 * static_cast<size_t>(cv::countNonZero(inliers)) < on_board.size();
}

BoardView FindCharuco(const Board& board, const cv::Mat& image) {
  BoardView view;
  const auto charuco = OpenCvBoard(board);
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(image, charuco->dictionary, corners, ids);
  if (ids.size() < 4) return view;
  view.contradicts = Contradicts(*charuco, corners, ids);
  if (view.contradicts) return view;
  std::vector<cv::Point2f> pixels;
  std::vector<int> found;
  cv::aruco::interpolateCornersCharuco(corners, ids, image, charuco, pixels, found);
  if (static_cast<int>(found.size()) < kMinCorners) return view;
  const bool upwards = IsUpwards(*charuco);
  for (size_t i = 0; i < found.size(); ++i) {
    const Eigen::Vector2d at =
        Downwards(board, upwards, charuco->chessboardCorners[static_cast<size_t>(found[i])]) / board.square_m;
    view.corners.push_back(static_cast<int>(std::lround(at.y()) - 1) * board.CornerColumns() +
                           static_cast<int>(std::lround(at.x())) - 1);
    // OpenCV 4.6 counts these from the upper left corner of the first pixel, unlike all else.
    view.pixels.emplace_back(pixels[i].x - 0.5, pixels[i].y - 0.5);
  }
  // The window must not reach the markers.
  Refine(board, image, 0.5 * (1.0 - board.marker_m / board.square_m), &view);
  return view;
}

}  // namespace

std::vector<Marker> MarkersOf(const Board& board) {
  const auto charuco = OpenCvBoard(board);
  const bool upwards = IsUpwards(*charuco);
  std::vector<Marker> markers;
  for (size_t i = 0; i < charuco->objPoints.size(); ++i) {
    cv::Mat picture;
    charuco->dictionary->drawMarker(charuco->ids[i], kMarkerCells, picture, 1);
    Marker marker{Downwards(board, upwards, charuco->objPoints[i][0]), {}};
    for (int y = 0; y < kMarkerCells; ++y) {
      for (int x = 0; x < kMarkerCells; ++x) marker.black.push_back(picture.at<uchar>(y, x) == 0);
    }
    markers.push_back(marker);
  }
  return markers;
}

BoardView FindBoard(const Board& board, const cv::Mat& image) {
  return board.kind == Board::Kind::kChess ? FindChess(board, image) : FindCharuco(board, image);
}

}  // namespace plslam::calibration
