// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/dot_figure.h"

#include <algorithm>
#include <array>

#include "tools/evaluate/drawing/axes.h"

namespace plslam {
namespace {

constexpr double kRow_pt = 22.0;
constexpr double kTop_pt = 18.0;
constexpr double kBottom_pt = 23.0;
constexpr double kSide_pt = 12.0;

}  // namespace

Ink InkOf(size_t i) {
  static constexpr std::array<Ink, 7> kInks{
      {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}, {230, 159, 0}, {86, 180, 233}, {90, 90, 90}}};
  return kInks[i % kInks.size()];
}

Drawing DotFigure(const std::string& title, const std::string& axis, const std::vector<DotRow>& rows) {
  const double height = kRow_pt * static_cast<double>(rows.size());
  Drawing drawing;
  drawing.size = {kColumn_pt, kTop_pt + height + kBottom_pt};
  AddTitle(drawing, title);
  double largest = 1e-9;
  for (const DotRow& row : rows) {
    for (const double value : row.values) largest = std::max(largest, value);
  }
  Axes axes(drawing, {{kSide_pt, kTop_pt}, {kColumn_pt - 2.0 * kSide_pt, height}}, {0.0, 1.08 * largest},
            {0.0, height});
  axes.DrawGrid(axis, "");
  for (size_t i = 0; i < rows.size(); ++i) {
    // The name above, the dots below it.
    const double top = height - kRow_pt * static_cast<double>(i), y = top - 0.72 * kRow_pt;
    AddText(drawing, axes.At(0.0, top - 8.0) + Place(2.0, 0.0), rows[i].name);
    for (const double value : rows[i].values) axes.DrawDots({{value, y}}, 2.0, rows[i].ink);
    if (rows[i].values.empty()) continue;
    axes.DrawSegments({{Eigen::Vector2d(rows[i].median, y - 4.5), Eigen::Vector2d(rows[i].median, y + 4.5)}},
                      {{0, 0, 0}, 1.0, false});
  }
  axes.DrawFrame();
  return drawing;
}

}  // namespace plslam
