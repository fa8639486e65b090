// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tools/evaluate/drawing/drawing.h"

namespace plslam::evaluate {

/// Width of a column of a two-column journal, and the size of small type in it.
inline constexpr double kColumn_pt = 252.0;
inline constexpr double kType_pt = 7.0;

/// Range of an axis.
struct Range {
  double min = 0.0;
  double max = 1.0;
};

/// Distance of the marks of an axis, 1, 2 or 5 times a power of ten, so that `span` has at most `max_marks`.
double MarkDistance(double span, int max_marks);

/// A box in a drawing.
struct Box {
  Place corner = Place::Zero();
  Place size = Place::Zero();

  double Right() const { return corner.x() + size.x(); }
  double Bottom() const { return corner.y() + size.y(); }
};

/// An entry of a legend: a sample of a line, or of dots if `stroke.width_pt` is 0.
struct LegendEntry {
  std::string name;
  Stroke stroke;
  double dot_pt = 0.0;
};

/// One pair of axes in a drawing. Ranges must not be empty; `log_x` takes the logarithm of x, which must be positive.
class Axes {
 public:
  Axes(Drawing& drawing, const Box& area, const Range& x, const Range& y, bool log_x = false);

  Place At(double x, double y) const;
  bool Contains(double x, double y) const;

  /// Grid, marks and frame; the name of x below, that of y above the axis, level, as all text is.
  void DrawGrid(const std::string& x_name, const std::string& y_name);
  void DrawFrame();
  void DrawPath(const std::vector<Eigen::Vector2d>& data, const Stroke& stroke);
  /// Draws the dots within the axes.
  void DrawDots(const std::vector<Eigen::Vector2d>& data, double radius_pt, const Ink& ink);
  /// Draws the segments with both ends within the axes.
  void DrawSegments(const std::vector<std::array<Eigen::Vector2d, 2>>& data, const Stroke& stroke);
  /// Marks the start of a path.
  void DrawRing(const Eigen::Vector2d& data, const Ink& ink);

 private:
  void MarkX(double value);
  void MarkY(double value);

  Drawing& drawing_;
  Box area_;
  Range x_;
  Range y_;
  bool log_x_;
};

/// Axes of equal scale at column width around positions, below `top_pt`, and the height of the figure with them.
struct Plan {
  Box area;
  Range x;
  Range y;
  double height_pt = 0.0;
};

Plan PlanAround(const std::vector<Eigen::Vector2d>& positions, double top_pt);

void AddText(Drawing& drawing, const Place& at, const std::string& text, double anchor = 0.0,
             double size_pt = kType_pt, const Ink& ink = {40, 40, 40});

/// Adds the title of a figure at column width, in its first line: in a smaller font, and truncated, if it is too long.
void AddTitle(Drawing& drawing, const std::string& title);

/// Rows of entries from `at` (left end of the first base line), as many in a row as fit into `width_pt`. Returns the
/// base line of the row after.
double AddLegend(Drawing& drawing, const Place& at, double width_pt, const std::vector<LegendEntry>& entries);

}  // namespace plslam::evaluate
