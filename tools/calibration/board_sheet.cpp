// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/board_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace plslam::calibration {
namespace {

struct Paper {
  std::string_view name;
  double long_mm;
  double short_mm;
};
/// From the smallest to the largest.
constexpr std::array kPapers = {Paper{"A4 or Letter", 279.4, 210.0}, Paper{"A4", 297.0, 210.0},
                                Paper{"Letter", 279.4, 215.9},       Paper{"A3 or Tabloid", 420.0, 279.4},
                                Paper{"Tabloid", 431.8, 279.4},      Paper{"A3", 420.0, 297.0},
                                Paper{"A2", 594.0, 420.0},           Paper{"A1", 841.0, 594.0},
                                Paper{"A0", 1189.0, 841.0}};
/// Printers leave 4 to 6.4 mm at each side of the paper white.
constexpr double kMargin_mm = 8.0;
constexpr double kPointsPerMetre = 72.0 / 0.0254;
/// Base line of the text above the lower end of the sheet, and its size.
constexpr double kTextLine_points = 20.0, kText_points = 8.0;

std::string Pdf(const BoardSheet& sheet, const std::string& drawing) {
  const std::vector<std::string> objects = {
      "<< /Type /Catalog /Pages 2 0 R >>", "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      fmt::format(
          "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Contents 4 0 R /Resources << /Font << /F 5 "
          "0 R >> >> >>",
          sheet.width_m * kPointsPerMetre, sheet.height_m * kPointsPerMetre),
      fmt::format("<< /Length {} >>\nstream\n{}endstream", drawing.size(), drawing),
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  std::string pdf = "%PDF-1.4\n", table;
  for (size_t i = 0; i < objects.size(); ++i) {
    table += fmt::format("{:010} 00000 n \n", pdf.size());
    pdf += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  const size_t start = pdf.size();
  return pdf +
         fmt::format(
             "xref\n0 {0}\n0000000000 65535 f \n{1}trailer\n<< /Size {0} /Root 1 0 R >>\nstartxref\n{2}\n%%EOF\n",
             objects.size() + 1, table, start);
}

}  // namespace

BoardSheet SheetFor(const Board& board) {
  const double width_mm = 1e3 * board.width_m() + 2.0 * kMargin_mm;
  const double height_mm = 1e3 * board.height_m() + 2.0 * kMargin_mm;
  const auto* paper = std::ranges::find_if(kPapers, [&](const Paper& p) {
    return std::max(width_mm, height_mm) <= p.long_mm && std::min(width_mm, height_mm) <= p.short_mm;
  });
  if (paper == kPapers.end()) return {"", 1e-3 * width_mm, 1e-3 * height_mm};
  const bool upright = height_mm > width_mm;
  return {std::string(paper->name), 1e-3 * (upright ? paper->short_mm : paper->long_mm),
          1e-3 * (upright ? paper->long_mm : paper->short_mm)};
}

std::string PaperText(const BoardSheet& sheet) {
  if (!sheet.paper.empty()) return sheet.paper + " paper";
  return fmt::format("paper of at least {:.0f} by {:.0f} mm", std::ceil(1e3 * sheet.width_m),
                     std::ceil(1e3 * sheet.height_m));
}

std::string BoardPdf(const Board& board) {
  const BoardSheet sheet = SheetFor(board);
  const double left_m = 0.5 * (sheet.width_m - board.width_m()), top_m = 0.5 * (sheet.height_m - board.height_m());
  std::string drawing = "0 g\n";
  for (const BlackRectangle& r : BoardPattern(board)) {
    const Eigen::Vector2d size = r.size_m * kPointsPerMetre;
    const double x = (left_m + r.upper_left_m.x()) * kPointsPerMetre;
    const double y = (sheet.height_m - top_m - r.upper_left_m.y()) * kPointsPerMetre - size.y();
    drawing += fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re\n", x, y, size.x(), size.y());
  }
  // A small margin holds the text only at the rim that printers reach.
  const double line = std::min(kTextLine_points, top_m * kPointsPerMetre - kText_points);
  drawing +=
      fmt::format("f\nBT /F {} Tf {:.2f} {:.2f} Td (--board {}, {}: print at 100 % on {}) Tj ET\n", kText_points,
                  left_m * kPointsPerMetre, line, BoardText(board), BoardMeasure(board), PaperText(sheet));
  return Pdf(sheet, drawing);
}

}  // namespace plslam::calibration
