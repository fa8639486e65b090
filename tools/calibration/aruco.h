// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "tools/calibration/board.h"

/// OpenCV's ArUco, of which version 4.7 changed most names, in one interface.
namespace plslam::calibration::aruco {

/// The dictionary of a Charuco board's markers, and that of an Aprilgrid's tags.
enum class Dictionary { kMarkers, kTags };

/// Corners of markers in an image, clockwise from each marker's first one, with their ids.
struct FoundMarkers {
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
};

/// Adaptive threshold: windows that grow by `step_px`; a pixel is dark if it is below their mean by `constant`.
struct Threshold {
  int step_px;
  double constant;
};

FoundMarkers DetectMarkers(const cv::Mat& image, Dictionary dictionary, int border_cells, const Threshold& threshold);
/// With OpenCV's own threshold and a border of one cell.
FoundMarkers DetectMarkers(const cv::Mat& image, Dictionary dictionary);

/// A picture of a marker, one pixel for each cell.
cv::Mat DrawMarker(Dictionary dictionary, int id, int cells, int border_cells);

/// A Charuco board as OpenCV 4.6 lays it, in metres, y down: corners of its markers clockwise from the upper left one,
/// their numbers, and its inner corners.
struct CharucoLayout {
  std::vector<std::vector<cv::Point3f>> markers;
  std::vector<int> ids;
  std::vector<cv::Point3f> corners;
};
CharucoLayout LayoutOf(const Board& board);

/// Inner corners of a Charuco board, interpolated between its markers: indices into `CharucoLayout::corners`.
struct CharucoCorners {
  std::vector<int> indices;
  std::vector<cv::Point2f> pixels;
};
CharucoCorners InterpolateCorners(const cv::Mat& image, const Board& board, const FoundMarkers& markers);

}  // namespace plslam::calibration::aruco
