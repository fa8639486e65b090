// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tools/calibration/board.h"

namespace plslam::calibration {

/// The sheet that a board is printed on without scaling, the board in its middle.
struct BoardSheet {
  /// "A4 or Letter", "A3"; empty if the board is larger than A0.
  std::string paper;
  double width_m = 0.0;
  double height_m = 0.0;
};

/// Returns the smallest sheet with a white margin that printers leave free. A board that fits both A4 and Letter gets
/// the area that the two have in common, and so do A3 and Tabloid. The sheet lies as the board does, upright or not.
BoardSheet SheetFor(const Board& board);

/// "A4 or Letter paper", "paper of at least 1330 by 900 mm".
std::string PaperText(const BoardSheet& sheet);

/// The board as a PDF of one page, the size of its sheet. Printed without scaling, squares have their size. A line below
/// the board has its text for `--board`, its measure, and the paper.
std::string BoardPdf(const Board& board);

}  // namespace plslam::calibration
