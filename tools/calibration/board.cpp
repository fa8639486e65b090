// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/board.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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

namespace {

struct KindRow {
  Board::Kind kind;
  std::string_view name;
  size_t n_parts;
};
constexpr std::array kKinds = {KindRow{Board::Kind::kChess, "chess", 3}, KindRow{Board::Kind::kCharuco, "charuco", 4},
                               KindRow{Board::Kind::kAprilgrid, "aprilgrid", 4}};

std::string_view NameOf(Board::Kind kind) { return std::ranges::find(kKinds, kind, &KindRow::kind)->name; }

void ReadMarkers(const std::string& text, const std::vector<std::string>& parts, Board* board) {
  if (board->kind == Board::Kind::kAprilgrid) {
    board->marker_m = Length(text, parts[2]);
    if (!Read(parts[3], &board->spacing) || !(board->spacing >= 0.05 && board->spacing <= 1.0)) {
      Fail(text, fmt::format("'{}' is not a spacing from 0.05 to 1 sides of a tag", parts[3]));
    }
    board->square_m = board->marker_m * (1.0 + board->spacing);
  } else {
    board->marker_m = Length(text, parts[3]);
    if (board->marker_m >= board->square_m) Fail(text, "the markers must be smaller than the squares");
  }
  const bool tags = board->kind == Board::Kind::kAprilgrid;
  const int most = tags ? kMaxTags : kMaxMarkers;
  if (board->columns * board->rows / (tags ? 1 : 2) > most) {
    Fail(text, fmt::format("needs more than the {} markers of the dictionary", most));
  }
}

}  // namespace

Board ParseBoard(const std::string& text) {
  const std::vector<std::string> parts = Split(text, ':');
  const auto* row = std::ranges::find(kKinds, std::string_view(parts[0]), &KindRow::name);
  if (row == kKinds.end() || parts.size() != row->n_parts) {
    Fail(text,
         "expected chess:9x6:0.025 (inner corners, square in m), charuco:11x8:0.03:0.022 (squares, square and "
         "marker in m) or aprilgrid:6x6:0.088:0.3 (tags, tag in m, spacing in tags)");
  }
  Board board;
  board.kind = row->kind;
  const std::vector<std::string> sides = Split(parts[1], 'x');
  if (sides.size() != 2 || !Read(sides[0], &board.columns) || !Read(sides[1], &board.rows) ||
      std::min(board.columns, board.rows) < 3 || std::max(board.columns, board.rows) > kMaxSide) {
    Fail(text, fmt::format("'{}' is not COLUMNSxROWS, each from 3 to {}", parts[1], kMaxSide));
  }
  board.square_m = Length(text, parts[2]);
  if (board.kind != Board::Kind::kChess) {
    ReadMarkers(text, parts, &board);
  } else if (board.columns == board.rows) {
    Fail(text, "a chess board with as many columns as rows looks the same when it is turned: use another one");
  }
  return board;
}

std::string BoardText(const Board& board) {
  const std::string start = fmt::format("{}:{}x{}", NameOf(board.kind), board.columns, board.rows);
  switch (board.kind) {
    case Board::Kind::kCharuco:
      return fmt::format("{}:{}:{}", start, board.square_m, board.marker_m);
    case Board::Kind::kAprilgrid:
      return fmt::format("{}:{}:{}", start, board.marker_m, board.spacing);
    default:
      return fmt::format("{}:{}", start, board.square_m);
  }
}

std::string BoardMeasure(const Board& board) {
  return board.kind == Board::Kind::kAprilgrid ? fmt::format("tags of {:g} mm", 1e3 * board.marker_m)
                                               : fmt::format("squares of {:g} mm", 1e3 * board.square_m);
}

std::vector<Eigen::Vector2d> BoardCorners(const Board& board) {
  const auto at = [&](int i) {
    if (board.kind != Board::Kind::kAprilgrid) return (i + 1) * board.square_m;
    const int tag = i / 2;
    return board.spacing * board.marker_m + tag * board.square_m + i % 2 * board.marker_m;
  };
  std::vector<Eigen::Vector2d> corners;
  for (int row = 0; row < board.CornerRows(); ++row) {
    for (int column = 0; column < board.CornerColumns(); ++column) corners.emplace_back(at(column), at(row));
  }
  return corners;
}

namespace {

std::vector<BlackRectangle> MarkerCells(const Board& board, const std::vector<Marker>& markers) {
  std::vector<BlackRectangle> pattern;
  for (const Marker& marker : markers) {
    const auto side = static_cast<int>(std::lround(std::sqrt(static_cast<double>(marker.black.size()))));
    const double cell_m = board.marker_m / side;
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        if (!marker.black[static_cast<size_t>(y * side + x)]) continue;
        pattern.push_back({marker.upper_left_m + cell_m * Eigen::Vector2d(x, y), {cell_m, cell_m}});
      }
    }
  }
  return pattern;
}

/// The small squares at the corners of tags.
void AddCornerSquares(const Board& board, std::vector<BlackRectangle>* pattern) {
  const double side_m = board.spacing * board.marker_m;
  for (int row = 0; row <= board.rows; ++row) {
    for (int column = 0; column <= board.columns; ++column) {
      pattern->push_back({board.square_m * Eigen::Vector2d(column, row), {side_m, side_m}});
    }
  }
}

}  // namespace

std::vector<BlackRectangle> BoardPattern(const Board& board) {
  const std::vector<Marker> markers = MarkersOf(board);
  std::vector<BlackRectangle> pattern = MarkerCells(board, markers);
  if (board.kind == Board::Kind::kAprilgrid) {
    AddCornerSquares(board, &pattern);
    return pattern;
  }
  std::vector<bool> white(static_cast<size_t>(board.SquareColumns() * board.SquareRows()), false);
  const auto index = [&](int column, int row) { return static_cast<size_t>(row * board.SquareColumns() + column); };
  for (const Marker& marker : markers) {
    const Eigen::Vector2d centre = marker.upper_left_m.array() + 0.5 * board.marker_m;
    white[index(static_cast<int>(centre.x() / board.square_m), static_cast<int>(centre.y() / board.square_m))] = true;
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

}  // namespace plslam::calibration
