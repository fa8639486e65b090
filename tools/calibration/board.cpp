// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/board.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "tools/calibration/markers.h"

namespace plslam::calibration {
namespace {

constexpr int kMaxSide = 100;

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts{""};
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

template <class Number>
bool Read(const std::string& text, Number* value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
  return error == std::errc() && end == text.data() + text.size();
}

[[noreturn]] void Fail(const std::string& text, const std::string& why) {
  throw std::runtime_error(fmt::format("--board {}: {}", text, why));
}

double Length(const std::string& text, const std::string& part) {
  double value = 0.0;
  if (!Read(part, &value) || !(value >= 0.001 && value <= 1.0)) {
    Fail(text, fmt::format("'{}' is not a length from 0.001 to 1 m", part));
  }
  return value;
}

}  // namespace

Board ParseBoard(const std::string& text) {
  const std::vector<std::string> parts = Split(text, ':');
  const bool chess = parts[0] == "chess";
  if ((!chess && parts[0] != "charuco") || parts.size() != (chess ? 3U : 4U)) {
    Fail(text,
         "expected chess:9x6:0.025 (inner corners, square in m) or charuco:11x8:0.03:0.022 (squares, square and "
         "marker in m)");
  }
  Board board;
  board.kind = chess ? Board::Kind::kChess : Board::Kind::kCharuco;
  const std::vector<std::string> sides = Split(parts[1], 'x');
  if (sides.size() != 2 || !Read(sides[0], &board.columns) || !Read(sides[1], &board.rows) ||
      std::min(board.columns, board.rows) < 3 || std::max(board.columns, board.rows) > kMaxSide) {
    Fail(text, fmt::format("'{}' is not COLUMNSxROWS, each from 3 to {}", parts[1], kMaxSide));
  }
  board.square_m = Length(text, parts[2]);
  if (chess && board.columns == board.rows) {
    Fail(text, "a chess board of as many columns as rows looks alike when it is turned: take another one");
  }
  if (chess) return board;
  board.marker_m = Length(text, parts[3]);
  if (board.marker_m >= board.square_m) Fail(text, "the markers must be smaller than the squares");
  if (board.columns * board.rows / 2 > kMaxMarkers) {
    Fail(text, fmt::format("needs more than the {} markers of the dictionary", kMaxMarkers));
  }
  return board;
}

std::string BoardText(const Board& board) {
  if (board.kind == Board::Kind::kChess) {
    return fmt::format("chess:{}x{}:{}", board.columns, board.rows, board.square_m);
  }
  return fmt::format("charuco:{}x{}:{}:{}", board.columns, board.rows, board.square_m, board.marker_m);
}

std::vector<Eigen::Vector2d> BoardCorners(const Board& board) {
  std::vector<Eigen::Vector2d> corners;
  for (int row = 1; row <= board.CornerRows(); ++row) {
    for (int column = 1; column <= board.CornerColumns(); ++column) {
      corners.emplace_back(column * board.square_m, row * board.square_m);
    }
  }
  return corners;
}

std::vector<BlackRectangle> BoardPattern(const Board& board) {
  std::vector<BlackRectangle> pattern;
  std::vector<bool> white(static_cast<size_t>(board.SquareColumns() * board.SquareRows()), false);
  const auto index = [&](int column, int row) { return static_cast<size_t>(row * board.SquareColumns() + column); };
  if (board.kind == Board::Kind::kCharuco) {
    for (const Marker& marker : MarkersOf(board)) {
      const Eigen::Vector2d centre = marker.upper_left_m.array() + 0.5 * board.marker_m;
      white[index(static_cast<int>(centre.x() / board.square_m), static_cast<int>(centre.y() / board.square_m))] =
          true;
      const double cell_m = board.marker_m / kMarkerCells;
      for (int y = 0; y < kMarkerCells; ++y) {
        for (int x = 0; x < kMarkerCells; ++x) {
          if (!marker.black[static_cast<size_t>(y * kMarkerCells + x)]) continue;
          pattern.push_back({marker.upper_left_m + cell_m * Eigen::Vector2d(x, y), {cell_m, cell_m}});
        }
      }
    }
  }
  for (int row = 0; row < board.SquareRows(); ++row) {
    for (int column = 0; column < board.SquareColumns(); ++column) {
      const bool black = board.kind == Board::Kind::kChess ? (row + column) % 2 == 0 : !white[index(column, row)];
      if (!black) continue;
      pattern.push_back(
          {board.square_m * Eigen::Vector2d(column, row), Eigen::Vector2d(board.square_m, board.square_m)});
    }
  }
  return pattern;
}

std::string BoardPdf(const Board& board) {
  constexpr double kPointsPerMetre = 72.0 / 0.0254;
  constexpr double kMargin_m = 0.015;
  const double width = (board.SquareColumns() * board.square_m + 2.0 * kMargin_m) * kPointsPerMetre;
  const double height = (board.SquareRows() * board.square_m + 2.0 * kMargin_m) * kPointsPerMetre;
  std::string drawing = "0 g\n";
  for (const BlackRectangle& r : BoardPattern(board)) {
    const Eigen::Vector2d at = (r.upper_left_m.array() + kMargin_m) * kPointsPerMetre;
    const Eigen::Vector2d size = r.size_m * kPointsPerMetre;
    drawing +=
        fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re\n", at.x(), height - at.y() - size.y(), size.x(), size.y());
  }
  drawing += fmt::format("f\nBT /F 8 Tf {:.2f} 12 Td (--board {}, squares of {:g} mm: print at 100 %) Tj ET\n",
                         kMargin_m * kPointsPerMetre, BoardText(board), 1000.0 * board.square_m);
  const std::vector<std::string> objects = {
      "<< /Type /Catalog /Pages 2 0 R >>", "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      fmt::format(
          "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Contents 4 0 R /Resources << /Font << /F 5 "
          "0 R >> >> >>",
          width, height),
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

}  // namespace plslam::calibration
