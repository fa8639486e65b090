// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace plslam {

/// Range of an axis.
struct Range {
  double min = 0.0;
  double max = 1.0;
};

/// Distance of the marks of an axis, 1, 2 or 5 times a power of ten, so that `span` has at most `max_marks`.
double MarkDistance(double span, int max_marks);
/// The marks themselves, all within the range, and how one is named.
std::vector<double> Marks(const Range& range, int max_marks);
std::string MarkText(double value);

/// One pair of axes in a picture: the frame, the grid, marks, names, and lines in data coordinates. Draws with twice
/// the line width and text size, for pictures that are halved afterwards.
class Chart {
 public:
  /// `area` is the inside of the axes, in pixels. Ranges must not be empty.
  Chart(cv::Mat& picture, const cv::Rect& area, const Range& x, const Range& y);

  void DrawGrid(const std::string& x_name, const std::string& y_name);
  void DrawLine(const std::vector<cv::Point2d>& points, const cv::Scalar& colour, double thickness_px);
  void DrawMarker(const cv::Point2d& point, const cv::Scalar& colour);
  /// A row of samples of lines with their names, above the axes.
  void DrawLegend(const std::vector<std::pair<std::string, cv::Scalar>>& entries);

 private:
  cv::Point2d Pixel(const cv::Point2d& data) const;
  void Text(const std::string& text, cv::Point2d at, double share_left, double share_up);

  cv::Mat& picture_;
  cv::Rect area_;
  Range x_;
  Range y_;
};

}  // namespace plslam
