// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/aruco.h"

#include <opencv2/core/version.hpp>

#define PLSLAM_ARUCO_CLASSES (CV_VERSION_MAJOR * 100 + CV_VERSION_MINOR >= 407)
#if PLSLAM_ARUCO_CLASSES
#include <opencv2/objdetect/charuco_detector.hpp>
#else
#include <opencv2/aruco/charuco.hpp>
#endif

namespace plslam::calibration::aruco {
namespace {

auto OpenCvDictionary(Dictionary dictionary) {
  return cv::aruco::getPredefinedDictionary(dictionary == Dictionary::kMarkers ? cv::aruco::DICT_5X5_250
                                                                               : cv::aruco::DICT_APRILTAG_36h11);
}

#if PLSLAM_ARUCO_CLASSES

FoundMarkers Detect(const cv::Mat& image, Dictionary dictionary, const cv::aruco::DetectorParameters& parameters) {
  FoundMarkers found;
  cv::aruco::ArucoDetector(OpenCvDictionary(dictionary), parameters).detectMarkers(image, found.corners, found.ids);
  return found;
}

cv::aruco::CharucoBoard OpenCvBoard(const Board& board) {
  cv::aruco::CharucoBoard charuco({board.columns, board.rows}, static_cast<float>(board.square_m),
                                  static_cast<float>(board.marker_m), OpenCvDictionary(Dictionary::kMarkers));
  // The first square of an even number of rows is white, as in OpenCV 4.6.
  charuco.setLegacyPattern(true);
  return charuco;
}

#else

FoundMarkers Detect(const cv::Mat& image, Dictionary dictionary, const cv::aruco::DetectorParameters& parameters) {
  FoundMarkers found;
  cv::aruco::detectMarkers(image, OpenCvDictionary(dictionary), found.corners, found.ids,
                           cv::makePtr<cv::aruco::DetectorParameters>(parameters));
  return found;
}

cv::Ptr<cv::aruco::CharucoBoard> OpenCvBoard(const Board& board) {
  return cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square_m),
                                         static_cast<float>(board.marker_m), OpenCvDictionary(Dictionary::kMarkers));
}

#endif

/// OpenCV 4.6 counts y of a board from below, later versions from above.
void TurnDownwards(const Board& board, CharucoLayout* layout) {
  if (layout->markers.front()[0].y < layout->markers.front()[3].y) return;
  const auto turn = [height = board.SquareRows() * board.square_m](cv::Point3f& p) {
    p.y = static_cast<float>(height - static_cast<double>(p.y));
  };
  for (auto& marker : layout->markers) {
    for (cv::Point3f& p : marker) turn(p);
  }
  for (cv::Point3f& p : layout->corners) turn(p);
}

}  // namespace

FoundMarkers DetectMarkers(const cv::Mat& image, Dictionary dictionary, int border_cells,
                           const Threshold& threshold) {
  cv::aruco::DetectorParameters parameters;
  parameters.markerBorderBits = border_cells;
  parameters.adaptiveThreshWinSizeStep = threshold.step_px;
  parameters.adaptiveThreshConstant = threshold.constant;
  return Detect(image, dictionary, parameters);
}

FoundMarkers DetectMarkers(const cv::Mat& image, Dictionary dictionary) { return Detect(image, dictionary, {}); }

#if PLSLAM_ARUCO_CLASSES

cv::Mat DrawMarker(Dictionary dictionary, int id, int cells, int border_cells) {
  cv::Mat picture;
  OpenCvDictionary(dictionary).generateImageMarker(id, cells, picture, border_cells);
  return picture;
}

CharucoLayout LayoutOf(const Board& board) {
  const cv::aruco::CharucoBoard charuco = OpenCvBoard(board);
  CharucoLayout layout{charuco.getObjPoints(), charuco.getIds(), charuco.getChessboardCorners()};
  TurnDownwards(board, &layout);
  return layout;
}

CharucoCorners InterpolateCorners(const cv::Mat& image, const Board& board, const FoundMarkers& markers) {
  CharucoCorners found;
  FoundMarkers given = markers;
  cv::aruco::CharucoDetector(OpenCvBoard(board))
      .detectBoard(image, found.pixels, found.indices, given.corners, given.ids);
  return found;
}

#else

cv::Mat DrawMarker(Dictionary dictionary, int id, int cells, int border_cells) {
  cv::Mat picture;
  OpenCvDictionary(dictionary)->drawMarker(id, cells, picture, border_cells);
  return picture;
}

CharucoLayout LayoutOf(const Board& board) {
  const auto charuco = OpenCvBoard(board);
  CharucoLayout layout{charuco->objPoints, charuco->ids, charuco->chessboardCorners};
  TurnDownwards(board, &layout);
  return layout;
}

CharucoCorners InterpolateCorners(const cv::Mat& image, const Board& board, const FoundMarkers& markers) {
  CharucoCorners found;
  cv::aruco::interpolateCornersCharuco(markers.corners, markers.ids, image, OpenCvBoard(board), found.pixels,
                                       found.indices);
  return found;
}

#endif

}  // namespace plslam::calibration::aruco
