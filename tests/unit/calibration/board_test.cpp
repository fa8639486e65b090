// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/board.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/unit/calibration/board_pictures.h"
#include "tools/calibration/board_faults.h"
#include "tools/calibration/board_sheet.h"
#include "tools/calibration/markers.h"

namespace plslam::calibration {
namespace {

using testing::HasSubstr;

TEST(Board, TextsAndMistakes) {
  for (const char* text : {"chess:9x6:0.025", "charuco:11x8:0.03:0.022", "aprilgrid:6x6:0.088:0.3"})
    EXPECT_EQ(BoardText(ParseBoard(text)), text);
  const auto error = [](const std::string& text) -> std::string {
    try {
      ParseBoard(text);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(error("circles:6x6:0.088"), HasSubstr("expected chess:9x6:0.025"));
  EXPECT_THAT(error("aprilgrid:6x6:0.088:3"), HasSubstr("'3' is not a spacing"));
  EXPECT_THAT(error("aprilgrid:30x20:0.02:0.3"), HasSubstr("587 markers"));
  EXPECT_THAT(error("chess:9x6"), HasSubstr("expected chess"));
  EXPECT_THAT(error("chess:9:0.02"), HasSubstr("'9' is not COLUMNSxROWS"));
  EXPECT_THAT(error("chess:7x7:0.02"), HasSubstr("looks the same when it is turned"));
  EXPECT_THAT(error("chess:9x6:25"), HasSubstr("'25' is not a length"));
  EXPECT_THAT(error("charuco:11x8:0.02:0.03"), HasSubstr("must be smaller"));
  EXPECT_THAT(error("charuco:40x40:0.02:0.01"), HasSubstr("250 markers"));
}

class RenderedBoard : public testing::TestWithParam<const char*> {};

/// The drawn board agrees with the detector's, corner by corner: a wrong parity or direction would show here.
TEST_P(RenderedBoard, CornersAreDetectedAtTheirTruePositions) {
  const Board board = ParseBoard(GetParam());
  const CameraCalibration camera = test::KnownRig("radtan").left;
  const SE3 T = SE3(Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.6, 0.8, 0.0))),
                    Eigen::Vector3d(-0.14, -0.1, 0.5));
  const BoardView view = FindBoard(board, test::RenderBoard(board, test::RaysOf(camera), T, 2.0, 1));
  const BoardView truth = test::SeenBoard(board, camera, T, 0.0, 1);
  ASSERT_EQ(truth.corners.size(), BoardCorners(board).size());
  EXPECT_GE(10 * view.corners.size(), 8 * truth.corners.size());
  std::vector<Eigen::Vector2d> seen = view.pixels;
  if (board.kind == Board::Kind::kChess && (seen.front() - truth.pixels.front()).norm() > 10.0) {
    std::reverse(seen.begin(), seen.end());
  }
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0.0;
  for (size_t i = 0; i < seen.size(); ++i) {
    const Eigen::Vector2d error = seen[i] - truth.pixels[static_cast<size_t>(view.corners[i])];
    EXPECT_LT(error.norm(), 0.5) << i << " " << error.transpose();
    sum += error;
    squares += error.squaredNorm();
  }
  const auto n = static_cast<double>(seen.size());
  EXPECT_LT((sum / n).norm(), 0.04) << "no bias, such as that of half a pixel";
  EXPECT_LT(std::sqrt(squares / n), 0.2);
}

INSTANTIATE_TEST_SUITE_P(Boards, RenderedBoard,
                         testing::Values("chess:9x6:0.025", "charuco:11x8:0.025:0.018", "charuco:8x7:0.03:0.02",
                                         "aprilgrid:6x4:0.035:0.3", "aprilgrid:4x3:0.05:0.25"));

/// As Kalibr draws it: tag 0 in the lower left, its code 0xd5d628584 from the upper left cell on, set bits white.
TEST(Board, AprilgridIsKalibrs) {
  const Board board = ParseBoard("aprilgrid:6x5:0.1:0.3");
  const std::vector<Marker> tags = MarkersOf(board);
  ASSERT_EQ(tags.size(), 30U);
  EXPECT_NEAR(tags[0].upper_left_m.x(), 0.03, 1e-6);
  EXPECT_NEAR(tags[0].upper_left_m.y(), 0.03 + 4 * 0.13, 1e-6);
  EXPECT_NEAR(tags[7].upper_left_m.x(), 0.16, 1e-6);
  EXPECT_NEAR(tags[7].upper_left_m.y(), 0.03 + 3 * 0.13, 1e-6);
  uint64_t code = 0;
  for (size_t y = 0; y < 10; ++y) {
    for (size_t x = 0; x < 10; ++x) {
      const bool black = tags[0].black[10 * y + x];
      if (std::min(x, y) < 2 || std::max(x, y) > 7) {
        EXPECT_TRUE(black) << x << " " << y;
      } else {
        code = 2 * code + (black ? 0 : 1);
      }
    }
  }
  EXPECT_EQ(code, 0xd5d628584U) << std::hex << code;
  EXPECT_NEAR(BoardCorners(board).back().x(), board.width_m() - 0.03, 1e-9);
}

TEST(BoardSheet, IsTheSmallestPaperWithAMargin) {
  const auto paper = [](const std::string& board) { return PaperText(SheetFor(ParseBoard(board))); };
  EXPECT_EQ(paper("charuco:11x8:0.023:0.017"), "A4 or Letter paper") << "as the documents propose";
  EXPECT_EQ(paper("charuco:8x11:0.023:0.017"), "A4 or Letter paper");
  EXPECT_EQ(paper("charuco:12x8:0.023:0.017"), "A4 paper");
  EXPECT_EQ(paper("charuco:10x8:0.0245:0.017"), "Letter paper");
  EXPECT_EQ(paper("charuco:11x8:0.03:0.022"), "A3 or Tabloid paper");
  EXPECT_EQ(paper("aprilgrid:6x6:0.088:0.3"), "A0 paper");
  EXPECT_EQ(paper("chess:12x9:0.1"), "paper of at least 1316 by 1016 mm");
}

TEST(BoardSheet, LiesAsTheBoardDoes) {
  const BoardSheet wide = SheetFor(ParseBoard("charuco:11x8:0.023:0.017"));
  const BoardSheet upright = SheetFor(ParseBoard("charuco:8x11:0.023:0.017"));
  EXPECT_DOUBLE_EQ(wide.width_m, 0.2794);
  EXPECT_DOUBLE_EQ(wide.height_m, 0.21);
  EXPECT_DOUBLE_EQ(upright.width_m, wide.height_m);
  EXPECT_DOUBLE_EQ(upright.height_m, wide.width_m);
}

TEST(BoardPdf, HasThePrintSizeAndAllSquares) {
  const std::string pdf = BoardPdf(ParseBoard("chess:9x6:0.025"));
  // 279.4 x 210 mm in points: what A4 and Letter have in common.
  EXPECT_THAT(pdf, HasSubstr("/MediaBox [0 0 792.0000 595.2756]"));
  size_t n = 0;
  for (size_t at = 0; (at = pdf.find(" 70.8661 70.8661 re\n", at)) != std::string::npos; ++at) ++n;
  EXPECT_EQ(n, 35U);
  // The upper left square: (279.4 - 250) / 2 mm from the left, (210 - 175) / 2 + 25 mm from the top.
  EXPECT_THAT(pdf, HasSubstr("\n41.6693 474.8031 70.8661 70.8661 re\n"));
  EXPECT_THAT(pdf, HasSubstr("(--board chess:9x6:0.025, squares of 25 mm: print at 100 % on A4 or Letter paper)"));
  EXPECT_THAT(pdf, testing::EndsWith("%%EOF\n"));
  const size_t start = std::stoul(pdf.substr(pdf.find("startxref\n") + 10));
  EXPECT_EQ(pdf.substr(start, 5), "xref\n");
}

/// A view of some corners, by row and column.
BoardView ViewOf(const Board& board, const std::vector<std::pair<int, int>>& corners) {
  BoardView view;
  for (const auto& [row, column] : corners) view.corners.push_back(row * board.CornerColumns() + column);
  return view;
}

std::string UnseenEdge(const Board& board, const std::vector<std::pair<int, int>>& corners, int n_images = 10) {
  BoardFaults faults(board);
  faults.Count({});
  for (int i = 0; i < n_images; ++i) faults.Count(ViewOf(board, corners));
  EXPECT_EQ(faults.Contradiction(), "");
  return faults.UnseenEdge();
}

TEST(BoardFaults, AnEdgeThatNoImageShows) {
  const Board board = ParseBoard("charuco:5x4:0.03:0.022");  // 4 x 3 corners
  EXPECT_EQ(UnseenEdge(board, {{0, 3}, {2, 0}}), "");
  EXPECT_EQ(UnseenEdge(board, {{0, 0}}, 9), "") << "too few images to decide";
  EXPECT_EQ(UnseenEdge(board, {{0, 0}, {1, 3}}),
            "none of 10 pictures shows the lowest row of the board charuco:5x4:0.03:0.022: does the board have fewer "
            "columns or rows? If not, hold it where the whole board is seen");
  EXPECT_THAT(UnseenEdge(board, {{1, 0}, {2, 3}}), HasSubstr("uppermost row"));
  EXPECT_THAT(UnseenEdge(board, {{0, 0}, {2, 2}}), HasSubstr("rightmost column"));
  EXPECT_THAT(UnseenEdge(board, {{0, 1}, {2, 3}}), HasSubstr("leftmost column"));
}

}  // namespace
}  // namespace plslam::calibration
